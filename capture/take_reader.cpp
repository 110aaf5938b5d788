#include <algorithm>
#include <atomic>
#include <deque>
#include <mutex>
#include <set>

#include "capture/added_file.h"
#include "capture/blank_picture.h"
#include "capture/derivation.h"
#include "capture/manifest_file.h"
#include "capture/sha256.h"
#include "capture/take.h"
#include "capture/track_reader.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/rig_io.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

struct CameraPlayback {
  std::vector<FrameRow> rows;
  std::unique_ptr<TrackReader> track;  // none when no row has a picture
  AddedContent added;                  // what is hidden in its pictures
  std::once_flag looked_at;
  bool shows_something = false;  // usually: what is one colour all over is no picture of its
  std::atomic<bool> told = false;
};

class FolderReader final : public TakeReader {
 public:
  explicit FolderReader(const fs::path& folder) : layout_(folder) {}

  Result<void> open();
  const TakeLayout& layout() const override { return layout_; }
  const TakeManifest& manifest() const override { return manifest_; }
  const Rig& rig() const override { return rig_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  int frame_count() const override { return frame_count_; }
  const std::vector<FrameRow>& rows(int camera) const override {
    FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(cameras_.size()), text("camera ", camera));
    return cameras_[static_cast<std::size_t>(camera)].rows;
  }
  Result<Frame> frame(int camera, int index) override;
  Result<Frame> part(int camera, int index, std::span<const PixelBox> boxes, PixelBox& box) override;
  Result<FrameSet> frame_set(int index) override;

 private:
  Result<void> read_rig();
  Result<void> read_camera(const TakeManifest::Camera& camera);
  Result<void> read_added();
  Result<Frame> row_of(int camera, int index, std::optional<std::int64_t>& media_index) const;
  Result<Frame> without_pixels(Frame frame, int index, const Error& error);
  Result<Frame> hide_added(const AddedContent& added, Frame frame) const;
  bool shows_something(CameraPlayback& playback) const;
  Frame blank(Frame frame, int index, CameraPlayback& playback) const;
  void look_at_order(const fs::path& side_file, const std::vector<FrameRow>& rows);
  void look_at_end(const TakeManifest::Camera& camera, const std::string& csv, bool has_pictures);
  void stop_at_the_cut(const TakeManifest::Camera& camera, CameraPlayback& playback);
  void warn(std::string sentence) {
    log::warning(sentence);
    warnings_.push_back(std::move(sentence));
  }

  const TakeLayout layout_;
  TakeManifest manifest_;
  Rig rig_;
  std::deque<CameraPlayback> cameras_;
  std::vector<std::string> warnings_;
  int frame_count_ = 0;
  bool is_derived_ = false;  // its media may hold more pictures than it has rows
  std::mutex reported_mutex_;
  std::set<std::pair<int, int>> reported_;  // damaged frames that were logged
};

Result<void> FolderReader::read_rig() {
  const Result<std::string> bytes = read_file(layout_.rig());
  if (!bytes) return fail(bytes.error().code, text(bytes.error().message, "; a take needs its rig"));
  Result<Rig> rig = parse_rig(*bytes, layout_.rig().string());
  if (!rig) return forward(rig);
  rig_ = std::move(*rig);
  auto bad = [&](const std::string& what) {
    return fail(ErrorCode::BadData, text(layout_.rig().string(), ": ", what));
  };
  for (const TakeManifest::Camera& c : manifest_.cameras) {
    const int index = camera_index(rig_, c.serial);
    if (index < 0) return bad(text("camera '", c.serial, "' of take.json is missing in this rig"));
    const CameraModel& model = rig_.cameras[static_cast<std::size_t>(index)].model;
    if (model.width != c.width || model.height != c.height)
      return bad(text("camera '", c.serial, "' is ", model.width, "x", model.height, " here but ", c.width,
                      "x", c.height, " in take.json"));
  }
  for (std::size_t i = 0; i < rig_.cameras.size(); ++i)
    if (i >= manifest_.cameras.size() || manifest_.cameras[i].serial != rig_.cameras[i].serial)
      return bad(text("camera '", rig_.cameras[i].serial, "' is not number ", i,
                      " of take.json; both must list the same cameras in one order"));
  if (sha256(*bytes) != manifest_.rig_sha256)
    return bad(
        "not the file that was recorded (its SHA-256 differs from take.json's); put it back, and give the "
        "take another calibration with `floatstage take set-rig`");
  return {};
}

// Rows whose pictures are not in the file any more are not played: the side file promises, the media file
// delivers.
void FolderReader::stop_at_the_cut(const TakeManifest::Camera& camera, CameraPlayback& playback) {
  const std::int64_t there = playback.track->pictures();
  const std::string media = (layout_.folder() / camera.media).string();
  const auto beyond = std::find_if(playback.rows.begin(), playback.rows.end(), [&](const FrameRow& row) {
    return row.media_index && *row.media_index >= there;
  });
  if (beyond != playback.rows.end()) {
    const auto row = beyond - playback.rows.begin();
    warn(text(media, " ends after ", there, " pictures: camera '", camera.serial, "' plays up to row ", row,
              " of ", playback.rows.size()));
    playback.rows.erase(beyond, playback.rows.end());
    return;
  }
  const auto last = std::find_if(playback.rows.rbegin(), playback.rows.rend(),
                                 [](const FrameRow& row) { return row.media_index.has_value(); });
  const std::int64_t used = last == playback.rows.rend() ? 0 : *last->media_index + 1;
  // A recorder that is killed has often written one picture more than rows.
  if (used < there && !is_derived_ && (manifest_.complete || there - used > 1))
    warn(text(media, " has ", there - used, " pictures more than ",
              layout_.frames_csv(camera.serial).string(),
              "; the side file is the truth, they are not played"));
  else if (playback.track->cut() && manifest_.complete)
    warn(text(media, " is cut after its last picture; all of them are there"));
}

// What no recorder of ours writes: the take plays, and its times are not to be trusted.
void FolderReader::look_at_order(const fs::path& side_file, const std::vector<FrameRow>& rows) {
  const auto backward = std::adjacent_find(
      rows.begin(), rows.end(),
      [](const FrameRow& a, const FrameRow& b) { return b.info.exposure_start < a.info.exposure_start; });
  if (backward != rows.end())
    warn(text(side_file.string(), ": the time of row ", backward - rows.begin() + 1,
              " lies before that of the row above it; was the file edited?"));
  const auto repeated = std::adjacent_find(
      rows.begin(), rows.end(),
      [](const FrameRow& a, const FrameRow& b) { return b.info.sequence <= a.info.sequence; });
  if (repeated != rows.end())
    warn(text(side_file.string(), ": the sequence number of row ", repeated - rows.begin() + 1, ", ",
              (repeated + 1)->info.sequence, ", does not follow ", repeated->info.sequence,
              "; was the file edited?"));
}

// A complete take's side file ends with a whole line, and has a row for every picture.
void FolderReader::look_at_end(const TakeManifest::Camera& camera, const std::string& csv,
                               bool has_pictures) {
  const std::string side_file = layout_.frames_csv(camera.serial).string();
  if (!csv.ends_with('\n'))
    warn(text(side_file, " is cut in its last line; camera '", camera.serial, "' plays up to there"));
  std::error_code error;
  if (!has_pictures && fs::file_size(layout_.folder() / camera.media, error) > 0 && !error)
    warn(text(side_file, " has no row with a picture, but ", camera.media, " is there: camera '",
              camera.serial, "' does not play; put the side file back"));
}

Result<void> FolderReader::read_camera(const TakeManifest::Camera& camera) {
  const fs::path side_file = layout_.frames_csv(camera.serial);
  const Result<std::string> csv = read_file(side_file);
  if (!csv)
    return fail(csv.error().code,
                text(csv.error().message, "; without it camera '", camera.serial, "' has no times"));
  Result<std::vector<FrameRow>> rows =
      parse_frames_csv(*csv, static_cast<int>(cameras_.size()), side_file.string());
  if (!rows) return forward(rows);
  CameraPlayback& playback = cameras_.emplace_back();
  playback.rows = std::move(*rows);
  std::int64_t last = -1;
  for (std::size_t i = 0; i < playback.rows.size(); ++i) {
    FrameRow& row = playback.rows[i];
    if (!row.media_index) {
      row.info.status = FrameStatus::Lost;
      continue;
    }
    if (*row.media_index <= last)
      return fail(ErrorCode::BadData, text(side_file.string(), ": row ", i, ": media index ",
                                           *row.media_index, " does not follow ", last));
    last = *row.media_index;
  }
  look_at_order(side_file, playback.rows);
  if (manifest_.complete) look_at_end(camera, *csv, last >= 0);
  if (last >= 0) {
    Result<std::unique_ptr<TrackReader>> track = TrackReader::open(layout_.folder() / camera.media, camera);
    if (!track) return forward(track);
    playback.track = std::move(*track);
    stop_at_the_cut(camera, playback);
  }
  frame_count_ = std::max(frame_count_, static_cast<int>(playback.rows.size()));
  return {};
}

Result<void> FolderReader::read_added() {
  const Result<AddedFile> added = load_added(layout_);
  if (!added) return forward(added);
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const RigCamera& camera = rig_.cameras[i];
    cameras_[i].added = added->of(camera.serial);
    if (inside(cameras_[i].added, camera.model.width, camera.model.height).empty())
      return fail(ErrorCode::BadData,
                  text(added_file(layout_).string(), ": the bars of camera '", camera.serial,
                       "' leave nothing of its pictures; mend the file or remove it"));
  }
  return {};
}

Result<Frame> FolderReader::hide_added(const AddedContent& added, Frame frame) const {
  if (added.none() || frame.empty()) return frame;
  Result<Image> rgb = to_rgb(frame);
  if (!rgb) return forward(rgb);
  return make_frame(frame.info, without(added, std::move(*rgb)));
}

Result<void> FolderReader::open() {
  Result<TakeManifest> manifest = load_manifest(layout_);
  if (!manifest) return forward(manifest);
  manifest_ = std::move(*manifest);
  const Result<std::optional<Derivation>> derivation = load_derivation(layout_.folder());
  if (!derivation) return forward(derivation);
  is_derived_ = derivation->has_value();
  if (Result<void> ok = read_rig(); !ok) return ok;
  for (const TakeManifest::Camera& camera : manifest_.cameras)
    if (Result<void> ok = read_camera(camera); !ok) return ok;
  if (Result<void> ok = read_added(); !ok) return ok;
  if (!manifest_.complete)
    warn(text(layout_.folder().string(), ": the recording was cut off; it plays up to the cut"));
  return {};
}

// What the frame is without its pixels; a frame of a gap, or beyond the last row, has none.
Result<Frame> FolderReader::row_of(int camera, int index, std::optional<std::int64_t>& media_index) const {
  if (camera < 0 || camera >= static_cast<int>(cameras_.size()) || index < 0 || index >= frame_count_)
    return fail(ErrorCode::InvalidArgument,
                text(layout_.folder().string(), " has no frame ", index, " of camera ", camera, ": it has ",
                     frame_count_, " frames of ", cameras_.size(), " cameras"));
  const std::vector<FrameRow>& rows = cameras_[static_cast<std::size_t>(camera)].rows;
  Frame frame;
  if (index < static_cast<int>(rows.size())) {
    const FrameRow& row = rows[static_cast<std::size_t>(index)];
    frame.info = row.info;
    media_index = row.media_index;
  } else {
    frame.info.camera = camera;
    frame.info.status = FrameStatus::Lost;
  }
  return frame;
}

// Where the media file is damaged, that frame without pixels.
Result<Frame> FolderReader::without_pixels(Frame frame, int index, const Error& error) {
  if (error.code != ErrorCode::BadData) return fail(error.code, error.message);
  frame.info.status = FrameStatus::Corrupt;
  const std::lock_guard lock(reported_mutex_);
  if (reported_.emplace(frame.info.camera, index).second)
    log::warning(text(error.message, ": frame ", index, " is left out"));
  return frame;
}

// Whether what stands behind the subject differs in itself, in most of some pictures.
bool FolderReader::shows_something(CameraPlayback& playback) const {
  std::call_once(playback.looked_at, [&] {
    constexpr std::int64_t kPictures = 5;
    const std::int64_t count = playback.track->pictures();
    std::vector<int> spreads;
    for (std::int64_t i = 0; i < kPictures; ++i) {
      const Result<std::shared_ptr<const std::byte[]>> pixels =
          playback.track->picture((2 * i + 1) * count / (2 * kPictures));
      if (pixels && !is_one_colour(playback.track->layout(), pixels->get()))
        spreads.push_back(border_spread(playback.track->layout(), pixels->get()));
    }
    playback.shows_something = !spreads.empty() && median(std::move(spreads)) >= kLeastBorderSpread;
  });
  return playback.shows_something;
}

// A picture that shows nothing, of a camera that usually shows something, is none.
Frame FolderReader::blank(Frame frame, int index, CameraPlayback& playback) const {
  frame.info.status = FrameStatus::Corrupt;
  if (!playback.told.exchange(true))
    log::warning(text("camera '", rig_.cameras[static_cast<std::size_t>(frame.info.camera)].serial,
                      "': its picture is one colour all over in frame ", index,
                      ", as when a camera starts or a signal is lost: such pictures are left out"));
  return frame;
}

Result<Frame> FolderReader::frame(int camera, int index) {
  std::optional<std::int64_t> media_index;
  Result<Frame> frame = row_of(camera, index, media_index);
  if (!frame || !media_index) return frame;
  CameraPlayback& playback = cameras_[static_cast<std::size_t>(camera)];
  Result<std::shared_ptr<const std::byte[]>> pixels = playback.track->picture(*media_index);
  if (!pixels) return without_pixels(std::move(*frame), index, pixels.error());
  if (is_one_colour(playback.track->layout(), pixels->get()) && shows_something(playback))
    return blank(std::move(*frame), index, playback);
  frame->layout = playback.track->layout();
  frame->pixels = std::move(*pixels);
  return hide_added(playback.added, std::move(*frame));
}

Result<Frame> FolderReader::part(int camera, int index, std::span<const PixelBox> boxes, PixelBox& box) {
  std::optional<std::int64_t> media_index;
  Result<Frame> part = row_of(camera, index, media_index);
  if (!part || !media_index) return part;
  const CameraPlayback& playback = cameras_[static_cast<std::size_t>(camera)];
  const ImageLayout& whole = playback.track->layout();
  std::vector<PixelBox> taken;
  for (const PixelBox& one : boxes)
    if (const PixelBox pixels = whole_pixels(whole, one); !pixels.empty()) taken.push_back(pixels);
  box = around(taken);
  // What hides something looks at what is around it.
  if (!taken.empty() && playback.added.none()) {
    Result<std::shared_ptr<const std::byte[]>> pixels = playback.track->part(*media_index, taken);
    if (!pixels) return without_pixels(std::move(*part), index, pixels.error());
    if (*pixels && !is_one_colour(packed_layout(whole.format, box.width, box.height), pixels->get())) {
      part->layout = packed_layout(whole.format, box.width, box.height);
      part->pixels = std::move(*pixels);
      return part;
    }
  }
  if (taken.empty()) box = around(boxes);
  const Result<Frame> all = frame(camera, index);
  return all && !all->empty() ? crop(*all, box) : all;
}

Result<FrameSet> FolderReader::frame_set(int index) {
  std::vector<std::optional<Result<Frame>>> read(cameras_.size());
  parallel_for(read.size(), 0, [&](std::size_t i) { read[i] = frame(static_cast<int>(i), index); });
  FrameSet set;
  std::optional<Timestamp> earliest_present, earliest_expected;
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (!*read[i]) return forward(*read[i]);
    Frame& frame = **read[i];
    auto lower = [&](std::optional<Timestamp>& time) {
      time = time ? std::min(*time, frame.info.exposure_start) : frame.info.exposure_start;
    };
    if (!frame.empty()) lower(earliest_present);
    if (index < static_cast<int>(cameras_[i].rows.size())) lower(earliest_expected);
    set.frames.push_back(std::move(frame));
  }
  set.time = earliest_present.value_or(earliest_expected.value_or(Timestamp{}));
  return set;
}

}  // namespace

Result<std::unique_ptr<TakeReader>> TakeReader::open(const std::filesystem::path& folder) {
  auto reader = std::make_unique<FolderReader>(folder);
  if (Result<void> ok = reader->open(); !ok) return forward(ok);
  return {std::move(reader)};
}

}  // namespace floatstage::capture
