#include "apps/viewer/calibration/calibration_run.h"

#include <algorithm>
#include <chrono>

#include "capture/frame_source.h"
#include "capture/synchronizer.h"
#include "capture/time_offsets.h"
#include "core/text.h"

namespace floatstage::apps {

struct LiveRun::Lane {
  explicit Lane(bool is_recorded)
      : recorded(is_recorded),
        queue(recorded ? 8 : 2, recorded ? QueuePolicy::Block : QueuePolicy::DropOldest) {}
  const bool recorded;  // every picture counts, however long it takes
  std::string serial;
  std::unique_ptr<capture::FrameSource> source;
  BoundedQueue<Frame> queue;
  std::thread thread;
  std::atomic<bool> ended{false};
  std::string trouble;  // under the run's mutex
};

LiveRun::LiveRun(const studio::CaptureConfig& config, const LiveOptions& options)
    : config_(config), options_(options) {}

Result<std::unique_ptr<LiveRun>> LiveRun::start(const studio::CaptureConfig& config,
                                                const LiveOptions& options,
                                                const std::function<void(calib::Observations&)>& known) {
  std::unique_ptr<LiveRun> run(new LiveRun(config, options));
  const Result<capture::TimeOffsetFile> times = studio::load_times(config);
  if (!times) return forward(times);
  std::vector<calib::CalibrationCamera> cameras;
  for (const studio::CaptureConfig::Camera& from : config.cameras) {
    Result<std::unique_ptr<capture::FrameSource>> source = capture::open_source(from.source);
    if (!source) return forward(source);
    (*source)->stop_when(options.stop);
    const Result<capture::StreamInfo> info = (*source)->start();
    if (!info) return forward(info);
    auto lane = std::make_unique<Lane>(info->frame_count.has_value());
    lane->serial = from.serial;
    lane->source = std::move(*source);
    calib::CalibrationCamera camera;
    camera.serial = from.serial;
    camera.width = info->layout.width;
    camera.height = info->layout.height;
    camera.lens = options.target.lens;
    cameras.push_back(std::move(camera));
    run->status_.serials.push_back(from.serial);
    run->status_.sizes.emplace_back(info->layout.width, info->layout.height);
    run->offsets_.push_back(capture::offsets_of(*times, std::vector{from.serial}).front());
    run->lanes_.push_back(std::move(lane));
  }
  run->live_ = std::make_unique<calib::LiveCalibration>(options.target, std::move(cameras));
  known(run->live_->observations());
  if (const Result<void> sound = check(run->live_->observations()); !sound) return forward(sound);
  run->status_.coverage = calib::coverage_of(run->live_->observations());
  run->status_.advice = calib::advise(run->status_.coverage, options.goals);
  for (std::size_t i = 0; i < run->lanes_.size(); ++i)
    run->lanes_[i]->thread = std::thread([r = run.get(), i] { r->stream(i); });
  run->looking_ = std::thread([r = run.get()] { r->look(); });
  run->solving_ = std::thread([r = run.get()] { r->solve(); });
  return run;
}

LiveRun::~LiveRun() { stop(); }

void LiveRun::stream(std::size_t camera) {
  Lane& lane = *lanes_[camera];
  while (!stopping_) {
    Result<Frame> frame = lane.source->next(milliseconds(200));
    if (frame) {
      frame->info.camera = static_cast<int>(camera);
      if (!lane.queue.push(*std::move(frame))) break;
      continue;
    }
    if (frame.error().code == ErrorCode::Timeout) continue;
    if (frame.error().code != ErrorCode::EndOfStream && frame.error().code != ErrorCode::Cancelled) {
      std::lock_guard lock(mutex_);
      lane.trouble = frame.error().message;
    }
    break;
  }
  lane.ended = true;
  lane.queue.close();
}

void LiveRun::end_with(const Error& error) {
  std::lock_guard lock(mutex_);
  outcome_ = fail(error.code, error.message);
}

bool LiveRun::use(const FrameSet& set) {
  Result<calib::LiveInstant> instant = live_->look(set);
  if (!instant) {
    end_with(instant.error());
    return false;
  }
  std::lock_guard lock(mutex_);
  live_->keep(set, *instant);
  status_.sets = live_->sets();
  status_.counted = live_->counted();
  status_.passed_over = 0;
  for (const auto& lane : lanes_) {
    status_.passed_over += lane->queue.counters().dropped;
    if (!lane->trouble.empty()) status_.trouble = text("camera '", lane->serial, "': ", lane->trouble);
  }
  if (instant->counted) {
    status_.coverage = calib::coverage_of(live_->observations());
    status_.advice = calib::advise(status_.coverage, options_.goals);
    status_.completeness = calib::completeness(status_.coverage, options_.goals);
  }
  status_.instant = *std::move(instant);
  wake_.notify_all();
  return true;
}

// Lanes in turn, so that recordings stay in step; sets come from the frames' own times.
void LiveRun::look() {
  capture::SyncOptions sync;
  sync.frame_rate = config_.frame_rate;
  sync.tolerance = Nanoseconds{
      std::min<std::int64_t>(sync.tolerance.count, static_cast<std::int64_t>(0.4e9 / config_.frame_rate))};
  sync.offsets = offsets_;
  // Recordings are read in step, so that none is late because the machine is busy; a gap in one still ends.
  if (std::all_of(lanes_.begin(), lanes_.end(), [](const auto& lane) { return lane->recorded; }))
    sync.longest_wait = milliseconds(2000);
  Result<capture::Synchronizer> synchronizer =
      capture::Synchronizer::make(static_cast<int>(lanes_.size()), sync);
  if (!synchronizer) end_with(synchronizer.error());
  Timestamp newest;
  std::optional<Timestamp> first;
  std::vector<bool> over(lanes_.size(), false);
  bool going = synchronizer.has_value();
  while (going && !stopping_) {
    bool any = false;
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      if (over[i]) continue;
      const bool ended = lanes_[i]->ended;  // asked before: what it pushed last is then in the queue
      std::optional<Frame> frame =
          lanes_[i]->recorded ? lanes_[i]->queue.pop() : lanes_[i]->queue.pop_for(milliseconds(200));
      over[i] = !frame && (ended || lanes_[i]->recorded);
      any = any || !over[i];
      if (!frame) continue;
      newest = std::max(newest, frame->info.exposure_start);
      if (!first) first = frame->info.exposure_start;
      synchronizer->push(*std::move(frame));
    }
    if (!any || (options_.seconds > 0 && first && seconds(newest - *first) >= options_.seconds)) break;
    while (going) {
      const std::optional<FrameSet> set = synchronizer->next(newest);
      if (!set) break;
      going = use(*set);
    }
  }
  while (going && !stopping_) {
    const std::optional<FrameSet> set = synchronizer->drain();
    if (!set) break;
    going = use(*set);
  }
  std::lock_guard lock(mutex_);
  status_.over = true;
  wake_.notify_all();
}

void LiveRun::solve() {
  int solved = 0;
  for (bool last = false; !last;) {
    calib::Observations snapshot;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] {
        return stopping_ || status_.over || status_.counted >= solved + options_.solve_every;
      });
      if (stopping_) return;
      last = status_.over;
      if (last && status_.counted == solved) break;
      solved = status_.counted;
      snapshot = live_->observations();
    }
    calib::CalibrationOptions quick = options_.calibration;
    quick.holdout_every = 0;
    quick.time_offsets = false;
    calib::Observations thin = calib::thinned(snapshot, options_.quick_frames);
    if (auto* floor = std::get_if<calib::FloorBoard>(&thin.gauge); floor) thin.gauge = calib::OwnGauge{};
    Result<calib::Calibration> solution = calib::calibrate(thin, quick);
    std::lock_guard lock(mutex_);
    if (solution) {
      status_.solution = *std::move(solution);
      status_.solution_sets = solved;
      status_.trouble.clear();
    } else {
      status_.trouble = solution.error().message;
    }
  }
  std::lock_guard lock(mutex_);
  status_.settled = true;
  wake_.notify_all();
}

void LiveRun::wait() const {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return status_.settled || stopping_; });
}

LiveStatus LiveRun::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

void LiveRun::stop() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (const auto& lane : lanes_) lane->queue.close();
  for (const auto& lane : lanes_)
    if (lane->thread.joinable()) lane->thread.join();
  if (looking_.joinable()) looking_.join();
  if (solving_.joinable()) solving_.join();
  for (const auto& lane : lanes_) lane->source->stop();
}

void LiveRun::set_floor(double height) {
  std::lock_guard lock(mutex_);
  if (!live_->observations().views.empty())
    live_->observations().gauge = calib::FloorBoard{0, live_->observations().views.back().frame, height};
}

Result<void> LiveRun::outcome() const {
  std::lock_guard lock(mutex_);
  return outcome_;
}

calib::Observations LiveRun::observations() const {
  std::lock_guard lock(mutex_);
  return live_->observations();
}

}  // namespace floatstage::apps
