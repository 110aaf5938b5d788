#include "capture/replay/replay_source.h"

#include "capture/source_meter.h"
#include "core/check.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

class ReplaySource final : public FrameSource {
 public:
  ReplaySource(std::shared_ptr<TakeReader> take, int camera) : take_(std::move(take)), camera_(camera) {}

  Result<StreamInfo> start() override;
  Result<Frame> next(Nanoseconds timeout) override;
  void stop() override { started_ = false; }
  SourceStats stats() const override { return meter_.read(); }

 private:
  const std::shared_ptr<TakeReader> take_;
  const int camera_;
  bool started_ = false;
  int next_ = 0;
  std::string gone_;  // why the recording cannot be read any more
  SourceMeter meter_;
};

Result<StreamInfo> ReplaySource::start() {
  const TakeManifest::Camera& camera = take_->manifest().cameras[static_cast<std::size_t>(camera_)];
  if (started_)
    return fail(ErrorCode::InvalidArgument,
                text("camera '", camera.serial, "' is being replayed already; stop it first"));
  started_ = true;
  next_ = 0;
  gone_.clear();
  meter_.reset();
  return StreamInfo{camera.serial, packed_layout(camera.format, camera.width, camera.height),
                    take_->manifest().frame_rate, static_cast<std::int64_t>(take_->rows(camera_).size())};
}

Result<Frame> ReplaySource::next(Nanoseconds) {
  const std::string& serial = take_->manifest().cameras[static_cast<std::size_t>(camera_)].serial;
  if (!started_)
    return fail(ErrorCode::InvalidArgument,
                text("camera '", serial, "' is not being replayed; start it first"));
  if (!gone_.empty()) return fail(ErrorCode::Disconnected, gone_);
  while (next_ < static_cast<int>(take_->rows(camera_).size())) {
    Result<Frame> frame = take_->frame(camera_, next_);
    if (!frame) {
      gone_ = text("camera '", serial, "': its recording is gone (", frame.error().message, ")");
      return fail(ErrorCode::Disconnected, gone_);
    }
    ++next_;
    if (frame->empty()) {
      meter_.count_lost(1);
      continue;
    }
    meter_.count_delivered(*frame);
    return frame;
  }
  return fail(ErrorCode::EndOfStream, text("camera '", serial, "': the take is over"));
}

}  // namespace

std::unique_ptr<FrameSource> replay(std::shared_ptr<TakeReader> take, int camera) {
  FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(take->rig().cameras.size()),
                   text("camera ", camera));
  return std::make_unique<ReplaySource>(std::move(take), camera);
}

Result<std::unique_ptr<FrameSource>> open_replay(const std::string& address, const std::string& uri) {
  const std::size_t hash = address.rfind('#');
  const std::string folder = address.substr(0, hash),
                    serial = hash == std::string::npos ? "" : address.substr(hash + 1);
  if (folder.empty())
    return fail(ErrorCode::InvalidArgument,
                text("source '", uri, "': no folder; understood is ", kReplayUsage));
  Result<std::unique_ptr<TakeReader>> take = TakeReader::open(folder);
  if (!take) return fail(take.error().code, text("source '", uri, "': ", take.error().message));
  const Rig& rig = (*take)->rig();
  if (serial.empty() && rig.cameras.size() == 1) return replay(std::move(*take), 0);
  const int camera = camera_index(rig, serial);
  if (camera >= 0) return replay(std::move(*take), camera);
  std::string known;
  for (const RigCamera& c : rig.cameras) known += text(known.empty() ? "" : ", ", c.serial);
  return fail(ErrorCode::NotFound,
              text("source '", uri, "': ", serial.empty() ? "no camera is named" : "no camera of that name",
                   "; the take has ", known));
}

}  // namespace floatstage::capture
