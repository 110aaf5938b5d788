#include <chrono>
#include <ctime>
#include <mutex>
#include <optional>

#include "capture/sha256.h"
#include "capture/side_file.h"
#include "capture/take.h"
#include "capture/take_codec.h"
#include "capture/track_writer.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

// A longer jump of a sequence is a counter that was reset or wrapped, not frames that were lost.
constexpr std::uint64_t kLongestGap = 100'000;

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc = {};
  gmtime_r(&now, &utc);
  char buffer[32];
  std::strftime(buffer, sizeof buffer, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return buffer;
}

/// What is being recorded of one camera. Used by one thread at a time.
struct CameraRecording {
  explicit CameraRecording(SideFileWriter writer) : side_file(std::move(writer)) {}

  SideFileWriter side_file;
  std::unique_ptr<TrackWriter> track;  // from its first picture on
  PixelFormat format = PixelFormat::Rgb8;
  std::int64_t pictures = 0;
  std::optional<FrameInfo> last;  // of the last row
  std::optional<Error> failure;   // after which nothing may follow in its files
};

class FolderWriter final : public TakeWriter {
 public:
  FolderWriter(const fs::path& folder, const Rig& rig, const TakeWriterOptions& options, Claim claim)
      : layout_(folder), rig_(rig), options_(options), claim_(std::move(claim)) {}

  Result<void> start();
  Result<void> write(const Frame& frame) override;
  Result<void> finish() override;

 private:
  Unexpected refuse(int camera, const std::string& why) const {
    return fail(ErrorCode::InvalidArgument,
                text("camera '", rig_.cameras[static_cast<std::size_t>(camera)].serial, "': ", why));
  }
  Result<void> check_frame(const Frame& frame, const CameraRecording& camera) const;
  Result<void> begin_track(int index, CameraRecording& camera, const ImageLayout& layout);
  Result<void> write_gaps(CameraRecording& camera, const FrameInfo& next);
  Result<void> write_row(const Frame& frame, CameraRecording& camera);
  Result<void> write_manifest();

  const TakeLayout layout_;
  const Rig rig_;
  const TakeWriterOptions options_;
  const Claim claim_;
  std::vector<CameraRecording> cameras_;
  bool finished_ = false;
  std::mutex manifest_mutex_;  // guards manifest_ and its file
  TakeManifest manifest_;
};

Result<void> FolderWriter::write_manifest() { return write_file(layout_.manifest(), to_json(manifest_)); }

// The manifest comes last: a folder with one is a take.
Result<void> FolderWriter::start() {
  const std::string rig_json = to_json(rig_);
  if (Result<void> ok = write_file(layout_.rig(), rig_json); !ok) return ok;
  manifest_.label = options_.label;
  manifest_.created = options_.created.empty() ? utc_now() : options_.created;
  manifest_.writer = "floatstage " FLOATSTAGE_VERSION;
  manifest_.frame_rate = options_.frame_rate;
  manifest_.rig_sha256 = sha256(rig_json);
  for (const RigCamera& c : rig_.cameras) {
    Result<SideFileWriter> side_file = SideFileWriter::create(layout_.frames_csv(c.serial));
    if (!side_file) return forward(side_file);
    cameras_.emplace_back(std::move(*side_file));
    // The format is corrected when the first picture says otherwise.
    manifest_.cameras.push_back({c.serial, c.serial + ".mkv", name_of(options_.codec), PixelFormat::Rgb8,
                                 c.model.width, c.model.height});
  }
  return write_manifest();
}

Result<void> FolderWriter::check_frame(const Frame& frame, const CameraRecording& camera) const {
  const int index = frame.info.camera;
  if (camera.last && frame.info.sequence <= camera.last->sequence)
    return refuse(index, text("sequence ", frame.info.sequence, " does not follow ", camera.last->sequence,
                              "; a take's rows are in order, each frame once"));
  if (camera.last && frame.info.sequence - camera.last->sequence > kLongestGap)
    return refuse(index, text("sequence ", frame.info.sequence, " after ", camera.last->sequence,
                              " is no gap but a counter that was reset; begin a new take"));
  if (frame.empty()) return {};
  const ImageLayout& l = frame.layout;
  const CameraModel& model = rig_.cameras[static_cast<std::size_t>(index)].model;
  if (frame.info.status == FrameStatus::Lost) return refuse(index, "a lost frame has pixels");
  if (l.width != model.width || l.height != model.height)
    return refuse(index, text("a picture of ", l.width, "x", l.height, ", but the rig says ", model.width,
                              "x", model.height));
  if (camera.track && l.format != camera.format)
    return refuse(index,
                  text("a picture in ", name_of(l.format), " after pictures in ", name_of(camera.format)));
  if (l.format == PixelFormat::Mjpeg)
    return fail(
        ErrorCode::Unsupported,
        text("camera '", rig_.cameras[static_cast<std::size_t>(index)].serial,
             "': a take stores uncompressed pictures, not MJPEG; let the capture source decode them"));
  const ImageLayout packed = packed_layout(l.format, l.width, l.height);
  const std::size_t rows = packed.size_bytes / packed.stride;
  // The last row may end with its pixels, without the padding of the others.
  if (l.stride < packed.stride || l.size_bytes < l.stride * (rows - 1) + packed.stride)
    return refuse(index,
                  text("a buffer of ", l.size_bytes, " bytes with ", l.stride, " a row is too short for ",
                       l.width, "x", l.height, " pixels in ", name_of(l.format)));
  return {};
}

Result<void> FolderWriter::begin_track(int index, CameraRecording& camera, const ImageLayout& layout) {
  const RigCamera& rig_camera = rig_.cameras[static_cast<std::size_t>(index)];
  {
    const std::lock_guard lock(manifest_mutex_);
    TakeManifest::Camera& entry = manifest_.cameras[static_cast<std::size_t>(index)];
    if (entry.format != layout.format) {
      entry.format = layout.format;
      if (Result<void> ok = write_manifest(); !ok) return ok;
    }
  }
  Result<std::unique_ptr<TrackWriter>> track =
      TrackWriter::create(layout_.folder() / (rig_camera.serial + ".mkv"), rig_camera.serial, options_.codec,
                          layout, options_.frame_rate);
  if (!track) return forward(track);
  camera.track = std::move(*track);
  camera.format = layout.format;
  return {};
}

Result<void> FolderWriter::write_gaps(CameraRecording& camera, const FrameInfo& next) {
  if (!camera.last) return {};
  const FrameInfo before = *camera.last;
  const auto steps = static_cast<std::int64_t>(next.sequence - before.sequence);
  for (std::int64_t i = 1; i < steps; ++i) {
    FrameInfo lost;
    lost.camera = next.camera;
    lost.sequence = before.sequence + static_cast<std::uint64_t>(i);
    lost.status = FrameStatus::Lost;
    // Split so that the product cannot overflow, however far apart the two are.
    const std::int64_t span = (next.exposure_start - before.exposure_start).count;
    lost.exposure_start = before.exposure_start + Nanoseconds{span / steps * i + span % steps * i / steps};
    if (Result<void> ok = camera.side_file.write({lost, std::nullopt}); !ok) return ok;
    camera.last = lost;
  }
  return {};
}

// The picture first, then its row: a row never promises a picture that is not there.
Result<void> FolderWriter::write_row(const Frame& frame, CameraRecording& camera) {
  if (Result<void> ok = write_gaps(camera, frame.info); !ok) return ok;
  FrameRow row{frame.info, std::nullopt};
  if (frame.empty()) {
    row.info.status = FrameStatus::Lost;
  } else {
    if (Result<void> ok = camera.track->write(frame); !ok) return ok;
    row.media_index = camera.pictures++;
  }
  if (Result<void> ok = camera.side_file.write(row); !ok) return ok;
  camera.last = row.info;
  return {};
}

Result<void> FolderWriter::write(const Frame& frame) {
  const int index = frame.info.camera;
  if (index < 0 || index >= static_cast<int>(cameras_.size()))
    return fail(ErrorCode::InvalidArgument,
                text("frame of camera ", index, ", but the take has ", cameras_.size(), " cameras"));
  if (finished_) return refuse(index, "this take is finished; record a new one");
  CameraRecording& camera = cameras_[static_cast<std::size_t>(index)];
  if (camera.failure) return Unexpected{*camera.failure};
  if (Result<void> ok = check_frame(frame, camera); !ok) return ok;
  Result<void> ok;
  if (!frame.empty() && !camera.track) ok = begin_track(index, camera, frame.layout);
  if (ok) ok = write_row(frame, camera);
  if (!ok) camera.failure = ok.error();
  return ok;
}

Result<void> FolderWriter::finish() {
  if (finished_)
    return fail(ErrorCode::InvalidArgument,
                text("the take ", layout_.folder().string(), " is finished already"));
  finished_ = true;
  std::optional<Error> failure;
  for (CameraRecording& camera : cameras_) {
    if (!camera.failure && camera.track)
      if (Result<void> ok = camera.track->finish(); !ok) camera.failure = ok.error();
    if (camera.failure && !failure) failure = camera.failure;
  }
  if (failure) return Unexpected{*failure};
  const std::lock_guard lock(manifest_mutex_);
  manifest_.complete = true;
  return write_manifest();
}

// Only what a writer makes before its first frame: whoever put more there keeps it.
void undo(const TakeLayout& layout, const Rig& rig, bool made) {
  std::error_code ignored;
  fs::remove(layout.rig(), ignored);
  for (const RigCamera& camera : rig.cameras) fs::remove(layout.frames_csv(camera.serial), ignored);
  fs::remove(layout.manifest(), ignored);
  if (made) fs::remove(layout.folder(), ignored);
}

}  // namespace

Result<std::unique_ptr<TakeWriter>> TakeWriter::create(const std::filesystem::path& folder, const Rig& rig,
                                                       const TakeWriterOptions& options) {
  if (Result<void> ok = check(rig); !ok)
    return fail(ErrorCode::InvalidArgument,
                text("cannot record ", folder.string(), ": ", ok.error().message));
  if (!(options.frame_rate >= 0 && options.frame_rate <= 1'000'000))
    return fail(ErrorCode::InvalidArgument,
                text("cannot record ", folder.string(), ": ", options.frame_rate, " frames per second"));
  NewFolder ours;
  if (!options.is_claimed) {
    Result<NewFolder> claimed = claim_new_folder(folder);
    if (!claimed) return forward(claimed);
    ours = std::move(*claimed);
  }
  const bool made = ours.made;
  auto writer = std::make_unique<FolderWriter>(folder, rig, options, std::move(ours.claim));
  if (Result<void> ok = writer->start(); !ok) {
    writer.reset();
    undo(TakeLayout(folder), rig, made);
    return forward(ok);
  }
  return {std::move(writer)};
}

}  // namespace floatstage::capture
