#include "capture/synthetic/synthetic_source.h"

#include <chrono>
#include <climits>
#include <cmath>
#include <thread>
#include <vector>

#include "capture/source_meter.h"
#include "capture/source_uri.h"
#include "capture/studio_clock.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct Options {
  SyntheticRigOptions rig;
  SyntheticStudioOptions studio;
  int camera = 0;
  int frames = 0;      // 0: endless
  int gone_after = 0;  // that many of them it is unplugged; 0: never
  bool live = false;   // at its rate, on the studio's clock
  int loop = 0;        // of a live one: pictures that it shows again and again
  Nanoseconds late;    // of a live one: its clock is behind the others'
};

class SyntheticSource final : public FrameSource {
 public:
  explicit SyntheticSource(Options options) : options_(std::move(options)) {}

  Result<StreamInfo> start() override;
  Result<Frame> next(Nanoseconds timeout) override;
  void stop() override { studio_.reset(); }
  SourceStats stats() const override { return meter_.read(); }

 private:
  Result<void> wait_for_trigger(Nanoseconds timeout);
  Frame picture(int number);
  Unexpected interrupted() const {
    return fail(ErrorCode::Cancelled, text("synthetic camera ", options_.camera, ": interrupted"));
  }

  const Options options_;
  std::unique_ptr<SyntheticStudio> studio_;  // while started
  int next_ = 0;
  std::int64_t tick_ = 0;  // of a live camera: the next trigger, in periods of the studio's clock; 0: unknown
  int pose_ =
      0;  // which picture is due: at one time the same pose for all cameras, whenever they were started
  Timestamp exposed_;
  std::vector<Frame> loop_;
  SourceMeter meter_;
};

Result<StreamInfo> SyntheticSource::start() {
  if (studio_)
    return fail(ErrorCode::InvalidArgument,
                text("synthetic camera ", options_.camera, " is started already; stop it first"));
  SyntheticStudioOptions stage = options_.studio;
  stage.stop = [this] { return stopped(); };
  Result<SyntheticStudio> studio = SyntheticStudio::create(synthetic_rig(options_.rig), stage);
  if (!studio) return forward(studio);
  studio_ = std::make_unique<SyntheticStudio>(std::move(*studio));
  next_ = 0;
  tick_ = 0;
  meter_.reset();
  for (int i = static_cast<int>(loop_.size()); options_.live && i < options_.loop; ++i) {
    Frame frame = studio_->shoot(options_.camera, i).frame;
    if (stopped()) {
      stop();
      return interrupted();
    }
    loop_.push_back(std::move(frame));
  }
  StreamInfo info;
  info.name = studio_->published_rig().cameras[static_cast<std::size_t>(options_.camera)].serial;
  info.layout = packed_layout(PixelFormat::Rgb8, options_.rig.width, options_.rig.height);
  info.frame_rate = options_.studio.frame_rate;
  if (options_.frames > 0) info.frame_count = options_.frames;
  return info;
}

// Live cameras are triggered together, at multiples of the period. One that nobody read for a while has lost
// what it could not hold.
Result<void> SyntheticSource::wait_for_trigger(Nanoseconds timeout) {
  const double period = 1e9 / options_.studio.frame_rate;
  const auto instant = [&](std::int64_t tick) {
    return Timestamp{std::llround(static_cast<double>(tick) * period)};
  };
  const Timestamp now = studio_now();
  if (tick_ == 0) tick_ = static_cast<std::int64_t>(static_cast<double>(now.ns) / period) + 1;
  for (constexpr std::int64_t kHeld = 8; instant(tick_ + kHeld) < now; ++tick_, ++next_) meter_.count_lost(1);
  const Nanoseconds left = instant(tick_) + options_.late - now;
  std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(left, timeout).count));
  if (left > timeout)
    return fail(ErrorCode::Timeout, text("synthetic camera ", options_.camera, ": not its time yet"));
  pose_ = static_cast<int>(tick_ % options_.loop);
  exposed_ = instant(tick_++) + options_.late;
  return {};
}

// A live camera has rendered its pictures before it starts: whoever looks at its rate shall not see the
// renderer's.
Frame SyntheticSource::picture(int number) {
  if (!options_.live) return studio_->shoot(options_.camera, number).frame;
  Frame frame = loop_[static_cast<std::size_t>(pose_)];
  frame.info.sequence = static_cast<std::uint64_t>(number);
  return frame;
}

Result<Frame> SyntheticSource::next(Nanoseconds timeout) {
  if (!studio_)
    return fail(ErrorCode::InvalidArgument,
                text("synthetic camera ", options_.camera, " is not started; start it first"));
  const int end = options_.frames > 0 ? options_.frames : INT_MAX;
  while (next_ < end) {
    if (options_.gone_after > 0 && next_ >= options_.gone_after)
      return fail(ErrorCode::Disconnected,
                  text("synthetic camera ", options_.camera, " was unplugged; stop and start it"));
    if (options_.live)
      if (Result<void> due = wait_for_trigger(timeout); !due) return forward(due);
    Frame frame = picture(next_++);
    if (!options_.live && stopped()) return interrupted();  // it was left unfinished
    if (options_.live) frame.info.exposure_start = exposed_;
    if (frame.empty()) {
      meter_.count_lost(1);
      continue;
    }
    meter_.count_delivered(frame);
    return frame;
  }
  return fail(ErrorCode::EndOfStream,
              text("synthetic camera ", options_.camera, ": its ", end, " frames are over"));
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_synthetic(const std::string& options, const std::string& uri) {
  constexpr double kMostDropped = 0.99;  // a camera that loses everything would never deliver
  UriOptions given(options, uri);
  Options o;
  o.rig.cameras = given.integer("cameras", o.rig.cameras, 1, 1000);
  o.camera = given.integer("camera", 0, 0, o.rig.cameras - 1);
  o.rig.width = given.integer("width", o.rig.width, 1, 16384);
  o.rig.height = given.integer("height", o.rig.height, 1, 16384);
  o.frames = given.integer("frames", 0, 0, INT_MAX - 1);
  o.gone_after = given.integer("gone-after", 0, 0, INT_MAX - 1);
  o.studio.seed = given.whole("seed", o.studio.seed);
  o.studio.frame_rate = given.number("rate", o.studio.frame_rate, 0.001, 100'000);
  o.studio.samples = given.integer("samples", o.studio.samples, 1, 4096);
  o.studio.defects.noise = given.number("noise", 0, 0, 255);
  o.studio.defects.dropped_frames = given.number("dropped", 0, 0, kMostDropped);
  o.studio.defects.time_jitter = given.number("jitter", 0, 0, 1);
  o.late = milliseconds(given.integer("late-ms", 0, 0, 1'000'000));
  const std::string live = given.word("live", "off");
  o.live = live == "on";
  o.loop = given.integer("loop", 25, 1, 10'000);
  const std::string shape = given.word("shape", "ring");
  if (Result<void> ok = given.finish(kSyntheticUsage); !ok) return forward(ok);
  if (live != "on" && live != "off")
    return fail(ErrorCode::InvalidArgument,
                text("source '", uri, "': live=", live, " is neither on nor off"));
  if (shape != "ring" && shape != "dome")
    return fail(ErrorCode::InvalidArgument,
                text("source '", uri, "': shape=", shape, " is neither ring nor dome"));
  o.rig.shape = shape == "dome" ? RigShape::QuarterDome : RigShape::Ring;
  return {std::make_unique<SyntheticSource>(std::move(o))};
}

}  // namespace floatstage::capture
