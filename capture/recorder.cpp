#include "capture/recorder.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>

#include "capture/recording_quality.h"
#include "core/check.h"
#include "core/file.h"
#include "core/log.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage {
namespace {

// A camera's numbering since it was started: which row its own sequence number stands for.
struct Rows {
  std::int64_t row_of_first = 0;
  std::uint64_t first = 0;
};

struct Lane {
  explicit Lane(std::size_t queue_frames) : queue(queue_frames, QueuePolicy::Block) {}

  std::optional<Rows> rows;              // its camera's thread alone
  std::optional<std::int64_t> last_row;  // as well
  BoundedQueue<Frame> queue;
  std::thread writer;
  std::mutex mutex;
  std::optional<Error> failure;  // under mutex
};

class TakeRecorder final : public Recorder {
 public:
  TakeRecorder(std::unique_ptr<TakeWriter> writer, std::filesystem::path folder, const Rig& rig,
               const RecorderOptions& options);
  ~TakeRecorder() override { join(); }

  Result<void> push(const Frame& frame) override;
  void restarted(int camera) override;
  RecordingQuality quality() const override;
  Result<RecordingQuality> finish() override;

 private:
  Timestamp origin_or(Timestamp first);
  Frame lost(int camera, std::int64_t row) const;
  std::optional<std::int64_t> row_of(Lane& lane, const FrameInfo& info);
  void write_all(Lane& lane);
  std::optional<Error> failure_of(Lane& lane) const;
  void join();

  const std::unique_ptr<TakeWriter> writer_;
  const std::filesystem::path folder_;
  const double period_ns_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  mutable std::mutex mutex_;
  std::optional<Timestamp> origin_;  // of row 0; written once, under mutex_
  mutable QualityMeter meter_;       // under mutex_
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
      period_ns_(1e9 / options.take.frame_rate),
      meter_(serials_of(rig), options.take.frame_rate, options.limits) {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    lanes_.push_back(std::make_unique<Lane>(options.queue_frames));
  for (const auto& lane : lanes_) lane->writer = std::thread([this, &lane] { write_all(*lane); });
}

void TakeRecorder::write_all(Lane& lane) {
  while (const std::optional<Frame> frame = lane.queue.pop()) {
    if (failure_of(lane)) continue;  // the queue is drained so that nobody waits for a disk that is full
    Result<void> written = writer_->write(*frame);
    if (written) {
      std::lock_guard lock(mutex_);
      if (!frame->empty()) meter_.recorded(frame->info.camera, frame->info.sequence, frame->info);
      continue;
    }
    log::error(written.error().message);
    std::lock_guard lock(lane.mutex);
    lane.failure = written.error();
  }
}

std::optional<Error> TakeRecorder::failure_of(Lane& lane) const {
  std::lock_guard lock(lane.mutex);
  return lane.failure;
}

// Row 0 is the instant of the first frame of all.
Timestamp TakeRecorder::origin_or(Timestamp first) {
  std::lock_guard lock(mutex_);
  if (!origin_) origin_ = first;
  return *origin_;
}

Frame TakeRecorder::lost(int camera, std::int64_t row) const {
  Frame gap;
  gap.info.camera = camera;
  gap.info.sequence = static_cast<std::uint64_t>(row);
  gap.info.exposure_start = *origin_ + Nanoseconds{std::llround(static_cast<double>(row) * period_ns_)};
  gap.info.status = FrameStatus::Lost;
  return gap;
}

// The instant's row; nothing for an instant before the first row, or one that the camera has filled already.
std::optional<std::int64_t> TakeRecorder::row_of(Lane& lane, const FrameInfo& info) {
  if (!lane.rows) {
    const Timestamp origin = origin_or(info.exposure_start);
    std::int64_t row = std::llround(static_cast<double>((info.exposure_start - origin).count) / period_ns_);
    if (row < 0) return std::nullopt;
    if (lane.last_row) {
      row = std::max(row, *lane.last_row + 1);
    } else {
      for (std::int64_t missed = 0; missed < row; ++missed) lane.queue.push(lost(info.camera, missed));
    }
    lane.rows = Rows{row, info.sequence};
  }
  const std::int64_t row =
      lane.rows->row_of_first + static_cast<std::int64_t>(info.sequence - lane.rows->first);
  if (lane.last_row && row <= *lane.last_row) {
    std::lock_guard lock(mutex_);
    meter_.duplicate(info.camera);
    return std::nullopt;
  }
  lane.last_row = row;
  return row;
}

void TakeRecorder::restarted(int camera) { lanes_[static_cast<std::size_t>(camera)]->rows.reset(); }

Result<void> TakeRecorder::push(const Frame& frame) {
  FLOATSTAGE_CHECK(frame.info.camera >= 0 && static_cast<std::size_t>(frame.info.camera) < lanes_.size(),
                   "a frame of no camera of the rig");
  Lane& lane = *lanes_[static_cast<std::size_t>(frame.info.camera)];
  if (std::optional<Error> failed = failure_of(lane)) return Unexpected{*failed};
  if (frame.empty()) return {};  // the next picture's sequence tells
  const std::optional<std::int64_t> row = row_of(lane, frame.info);
  if (!row) return {};
  Frame own = detached(frame);
  own.info.sequence = static_cast<std::uint64_t>(*row);
  lane.queue.push(std::move(own));
  return {};
}

RecordingQuality TakeRecorder::quality() const {
  std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < lanes_.size(); ++i)
    meter_.queue_peak(static_cast<int>(i), lanes_[i]->queue.counters().peak);
  return meter_.judge();
}

void TakeRecorder::join() {
  for (const auto& lane : lanes_) lane->queue.close();
  for (const auto& lane : lanes_)
    if (lane->writer.joinable()) lane->writer.join();
}

Result<RecordingQuality> TakeRecorder::finish() {
  join();
  Result<void> finished = writer_->finish();
  const RecordingQuality judged = quality();
  const Result<void> noted = write_file(TakeLayout(folder_).quality(), to_json(judged));
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
  return {std::make_unique<TakeRecorder>(std::move(*writer), folder, rig, options)};
}

}  // namespace floatstage
