#include "capture/recorder.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

#include "capture/disk_sync.h"
#include "capture/epoch_grid.h"
#include "capture/recording_quality.h"
#include "core/check.h"
#include "core/file.h"
#include "core/log.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

// A picture on its way to its file. The frame's sequence is its row already.
struct Shot {
  Frame frame;
  std::optional<std::uint64_t> counted;  // by how many pictures the camera's own count went on
  std::uint64_t failed = 0;              // of the source's pictures, since the camera's first one here
};

struct Lane {
  explicit Lane(std::size_t queue_frames) : queue(queue_frames, QueuePolicy::Block) {}

  // Its camera's thread alone.
  struct Seen {
    std::int64_t row = 0;
    std::uint64_t sequence = 0;  // the camera's own
  };
  std::optional<Seen> seen;                    // since it was started
  std::optional<std::uint64_t> last_sequence;  // of what was recorded since it was started
  std::optional<std::uint64_t> failed_before;

  BoundedQueue<Shot> queue;
  std::thread writer;
  std::uint64_t rows_before_first = 0;  // the writer's: gap rows to write before the first picture
  // Under the recorder's mutex.
  std::optional<std::int64_t> last_row;     // that it has a picture of
  std::optional<std::int64_t> kept_row;     // the last of them that is part of the take in any case
  std::map<std::int64_t, Shot> at_the_end;  // pictures of rows that may lie after the take's last one
  std::mutex mutex;
  std::optional<Error> failure;  // under mutex
};

class TakeRecorder final : public Recorder {
 public:
  TakeRecorder(std::unique_ptr<TakeWriter> writer, std::filesystem::path folder, const Rig& rig,
               const RecorderOptions& options);
  ~TakeRecorder() override { join(); }

  Result<void> push(const Frame& frame, std::uint64_t failed) override;
  void restarted(int camera) override;
  RecordingQuality quality() const override;
  Result<void> save_quality() const override;
  void end_at(Timestamp time) override;
  bool ended() const override;
  Result<RecordingQuality> finish() override;

 private:
  enum class Place { Left, Queued, Held };  // left out, to be written now, or to be seen at the end
  Place place(Lane& lane, const FrameInfo& info, std::int64_t& row);
  Timestamp instant_of(const FrameInfo& info) const {
    return info.exposure_start + offsets_[static_cast<std::size_t>(info.camera)];
  }
  Frame lost(int camera, std::int64_t row) const;
  void hold(Lane& lane, Shot shot);
  void release_held();
  void fill_up();
  void write(Lane& lane, const Shot& shot);
  void write_all(Lane& lane);
  std::optional<Error> failure_of(Lane& lane) const;
  void join();

  const std::unique_ptr<TakeWriter> writer_;
  const std::filesystem::path folder_;
  const double frame_rate_;
  const std::vector<Nanoseconds> offsets_;  // from a camera's stamps to its instants
  std::vector<std::unique_ptr<Lane>> lanes_;
  mutable std::mutex mutex_;              // over what follows
  std::optional<EpochGrid> grid_;         // from the first frame on
  std::optional<std::int64_t> end_from_;  // the last row is this one or a later one
  std::optional<std::int64_t> last_row_;  // of the take
  mutable QualityMeter meter_;
  std::unique_ptr<DiskSync> disk_sync_;
};

std::vector<std::string> serials_of(const Rig& rig) {
  std::vector<std::string> serials;
  for (const RigCamera& camera : rig.cameras) serials.push_back(camera.serial);
  return serials;
}

TakeRecorder::TakeRecorder(std::unique_ptr<TakeWriter> writer, std::filesystem::path folder, const Rig& rig,
                           const RecorderOptions& options)
    : writer_(std::move(writer)),
      folder_(std::move(folder)),
      frame_rate_(options.take.frame_rate),
      offsets_(offsets_of(options.times, rig)),
      meter_(serials_of(rig), options.take.frame_rate, options.limits) {
  if (options.origin) grid_.emplace(frame_rate_, *options.origin);
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    lanes_.push_back(std::make_unique<Lane>(options.queue_frames));
  for (const auto& lane : lanes_) lane->writer = std::thread([this, &lane] { write_all(*lane); });
  if (options.sync_seconds > 0)
    disk_sync_ = std::make_unique<DiskSync>(
        folder_, std::chrono::nanoseconds(static_cast<std::int64_t>(options.sync_seconds * 1e9)));
}

void TakeRecorder::write(Lane& lane, const Shot& shot) {
  if (failure_of(lane)) return;  // the queue is drained so that nobody waits for a disk that is full
  const Frame& frame = shot.frame;
  Result<void> written;
  for (; written && lane.rows_before_first < frame.info.sequence; ++lane.rows_before_first)
    written = writer_->write(lost(frame.info.camera, static_cast<std::int64_t>(lane.rows_before_first)));
  lane.rows_before_first = UINT64_MAX;
  if (written) written = writer_->write(frame);
  if (!written) {
    log::error(written.error().message);
    std::lock_guard lock(lane.mutex);
    lane.failure = written.error();
    return;
  }
  if (frame.empty()) return;
  std::lock_guard lock(mutex_);
  FrameInfo judged = frame.info;
  judged.exposure_start = instant_of(frame.info);
  meter_.recorded(frame.info.camera, frame.info.sequence, judged, shot.counted);
  meter_.failed(frame.info.camera, shot.failed);
}

void TakeRecorder::write_all(Lane& lane) {
  while (const std::optional<Shot> shot = lane.queue.pop()) write(lane, *shot);
}

std::optional<Error> TakeRecorder::failure_of(Lane& lane) const {
  std::lock_guard lock(lane.mutex);
  return lane.failure;
}

Frame TakeRecorder::lost(int camera, std::int64_t row) const {
  std::lock_guard lock(mutex_);
  Frame gap;
  gap.info.camera = camera;
  gap.info.sequence = static_cast<std::uint64_t>(row);
  gap.info.exposure_start = grid_->instant(row) - offsets_[static_cast<std::size_t>(camera)];
  gap.info.status = FrameStatus::Lost;
  return gap;
}

TakeRecorder::Place TakeRecorder::place(Lane& lane, const FrameInfo& info, std::int64_t& row) {
  std::optional<std::int64_t> expected;
  if (lane.seen) expected = lane.seen->row + static_cast<std::int64_t>(info.sequence - lane.seen->sequence);
  std::lock_guard lock(mutex_);
  const Timestamp instant = instant_of(info);
  if (!grid_) grid_.emplace(frame_rate_, instant);
  row = grid_->row_of(instant, expected);
  lane.seen = Lane::Seen{row, info.sequence};
  if (row < 0 || (last_row_ && row > *last_row_)) return Place::Left;
  if (lane.last_row && row <= *lane.last_row) {
    meter_.duplicate(info.camera);
    if (lane.last_sequence) {  // it counts for no later row
      meter_.counted_elsewhere(info.camera, info.sequence - *lane.last_sequence);
      lane.last_sequence = info.sequence;
    }
    return Place::Left;
  }
  lane.last_row = row;
  if (end_from_ && row >= *end_from_) return Place::Held;
  lane.kept_row = row;
  return Place::Queued;
}

void TakeRecorder::restarted(int camera) {
  Lane& lane = *lanes_[static_cast<std::size_t>(camera)];
  lane.seen.reset();
  lane.last_sequence.reset();
}

Result<void> TakeRecorder::push(const Frame& frame, std::uint64_t failed) {
  FLOATSTAGE_CHECK(frame.info.camera >= 0 && static_cast<std::size_t>(frame.info.camera) < lanes_.size(),
                   "a frame of no camera of the rig");
  Lane& lane = *lanes_[static_cast<std::size_t>(frame.info.camera)];
  if (std::optional<Error> failure = failure_of(lane)) return Unexpected{*failure};
  if (frame.empty()) return {};  // the next picture's time tells
  std::int64_t row = 0;
  const Place where = place(lane, frame.info, row);
  if (where == Place::Left) return {};
  std::optional<std::uint64_t> counted;
  if (lane.last_sequence) counted = frame.info.sequence - *lane.last_sequence;
  lane.last_sequence = frame.info.sequence;
  if (!lane.failed_before) lane.failed_before = failed;
  Shot shot{detached(frame), counted, failed - *lane.failed_before};
  shot.frame.info.sequence = static_cast<std::uint64_t>(row);
  if (where == Place::Held)
    hold(lane, std::move(shot));
  else
    lane.queue.push(std::move(shot));
  return {};
}

void TakeRecorder::end_at(Timestamp time) {
  std::lock_guard lock(mutex_);
  if (end_from_ || !grid_) return;
  end_from_ = std::max<std::int64_t>(0, grid_->nearest(time));
  // What is on its way to the disk cannot be called back.
  for (const auto& lane : lanes_)
    if (lane->last_row) end_from_ = std::max(*end_from_, *lane->last_row + 1);
}

bool TakeRecorder::ended() const {
  std::lock_guard lock(mutex_);
  return last_row_.has_value();
}

// The last row is the first one of which every camera has a picture.
void TakeRecorder::hold(Lane& lane, Shot shot) {
  std::lock_guard lock(mutex_);
  const auto row = static_cast<std::int64_t>(shot.frame.info.sequence);
  lane.at_the_end.emplace(row, std::move(shot));
  const bool complete = std::all_of(lanes_.begin(), lanes_.end(),
                                    [&](const auto& other) { return other->at_the_end.contains(row); });
  if (complete && (!last_row_ || row < *last_row_)) last_row_ = row;
}

// Where no row is complete, a camera is gone: the take ends with the last row that all others saw.
void TakeRecorder::release_held() {
  const bool complete = last_row_.has_value();
  for (const auto& lane : lanes_)
    if (!complete && !lane->at_the_end.empty()) {
      const std::int64_t newest = lane->at_the_end.rbegin()->first;
      last_row_ = std::min(last_row_.value_or(newest), newest);
    }
  for (const auto& lane : lanes_) {
    for (const auto& [row, shot] : lane->at_the_end) {
      if (row > *last_row_) break;
      write(*lane, shot);
      lane->kept_row = row;
    }
    if (lane->kept_row) last_row_ = std::max(last_row_.value_or(0), *lane->kept_row);
  }
}

// All cameras get equally many rows.
void TakeRecorder::fill_up() {
  for (std::size_t i = 0; i < lanes_.size() && last_row_; ++i) {
    Lane& lane = *lanes_[i];
    const auto camera = static_cast<int>(i);
    const std::int64_t first = lane.kept_row.value_or(-1) + 1;
    for (std::int64_t row = first; row <= *last_row_; ++row)
      write(lane, {lost(camera, row), std::nullopt, 0});
    meter_.missing_at_end(camera, static_cast<std::uint64_t>(*last_row_ + 1 - first));
  }
}

RecordingQuality TakeRecorder::quality() const {
  std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < lanes_.size(); ++i)
    meter_.queue_peak(static_cast<int>(i), lanes_[i]->queue.counters().peak);
  return meter_.judge();
}

Result<void> TakeRecorder::save_quality() const {
  return write_file(TakeLayout(folder_).quality(), to_json(quality()));
}

void TakeRecorder::join() {
  for (const auto& lane : lanes_) lane->queue.close();
  for (const auto& lane : lanes_)
    if (lane->writer.joinable()) lane->writer.join();
}

Result<RecordingQuality> TakeRecorder::finish() {
  join();
  release_held();
  fill_up();
  Result<void> finished = writer_->finish();
  const RecordingQuality judged = quality();
  const Result<void> noted = write_file(TakeLayout(folder_).quality(), to_json(judged));
  disk_sync_.reset();
  for (const auto& lane : lanes_)
    if (lane->failure) return Unexpected{*lane->failure};
  if (!finished) return forward(finished);
  if (!noted) return forward(noted);
  return judged;
}

}  // namespace

Frame detached(const Frame& frame) {
  if (frame.empty()) return frame;
  auto bytes = std::make_shared<std::byte[]>(frame.layout.size_bytes);
  std::memcpy(bytes.get(), frame.pixels.get(), frame.layout.size_bytes);
  Frame own = frame;
  own.pixels = std::move(bytes);
  return own;
}

Result<std::unique_ptr<Recorder>> Recorder::start(const std::filesystem::path& folder, const Rig& rig,
                                                  const RecorderOptions& options) {
  if (!(options.take.frame_rate > 0))
    return fail(ErrorCode::InvalidArgument, "recorder: the cameras' common frame rate is missing; give it");
  Result<std::unique_ptr<TakeWriter>> writer = TakeWriter::create(folder, rig, options.take);
  if (!writer) return forward(writer);
  if (!options.times.cameras.empty())
    if (Result<void> kept = save_time_offsets(options.times, times_file(TakeLayout(folder))); !kept)
      return forward(kept);
  return {std::make_unique<TakeRecorder>(std::move(*writer), folder, rig, options)};
}

}  // namespace floatstage::capture
