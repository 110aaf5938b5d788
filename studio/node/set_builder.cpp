#include "studio/node/set_builder.h"

#include <chrono>
#include <cmath>

#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

constexpr std::size_t kMostUnsettled = 64;  // deliveries of one camera that wait for their set

std::chrono::steady_clock::time_point time_point(Timestamp t) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(t.ns));
}

}  // namespace

Result<std::unique_ptr<SetBuilder>> SetBuilder::make(int cameras, const capture::SyncOptions& options) {
  Result<capture::Synchronizer> sync = capture::Synchronizer::make(cameras, options);
  if (!sync) return forward(sync);
  return std::unique_ptr<SetBuilder>(
      new SetBuilder(std::move(*sync), static_cast<std::size_t>(cameras), options.frame_rate));
}

void SetBuilder::push(const Frame& frame, Timestamp produced) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    ++counters_.frames;
    std::deque<Delivery>& lane = delivered_[static_cast<std::size_t>(frame.info.camera)];
    lane.push_back({frame.info.exposure_start, produced});
    if (lane.size() > kMostUnsettled) lane.pop_front();
    sync_.push(frame);
    settle(produced);
  }
  ready_.notify_one();
}

void SetBuilder::settle(Timestamp now) {
  while (std::optional<FrameSet> set = sync_.next(now)) {
    ++counters_.sets;
    if (newest_) ++counters_.overtaken;
    newest_ = timed(std::move(*set));
  }
}

TimedSet SetBuilder::timed(FrameSet set) {
  TimedSet out;
  if (!first_) first_ = set.time;
  const double periods = static_cast<double>((set.time - *first_).count) / period_;
  out.instant = {static_cast<std::uint64_t>(std::max(0L, std::lround(periods))), set.time};
  out.produced.resize(set.frames.size());
  bool any = false;
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    if (set.frames[i].empty()) continue;
    const Timestamp exposed = set.frames[i].info.exposure_start;
    std::deque<Delivery>& lane = delivered_[i];
    while (!lane.empty() && lane.front().exposed < exposed) lane.pop_front();
    if (lane.empty()) continue;
    out.produced[i] = lane.front().produced;
    out.first_produced = any ? std::min(out.first_produced, out.produced[i]) : out.produced[i];
    any = true;
  }
  if (!any) out.first_produced = set.time;
  out.images = std::move(set);
  return out;
}

std::optional<TimedSet> SetBuilder::newest(Timestamp deadline) {
  std::unique_lock lock(mutex_);
  // An instant that a camera missed is settled by time alone: look again now and then.
  constexpr Nanoseconds kLook = milliseconds(5);
  for (;;) {
    const Timestamp present = now();
    settle(present);
    if (newest_ || closed_ || present >= deadline) break;
    ready_.wait_until(lock, time_point(std::min(deadline, present + kLook)));
  }
  if (closed_) return std::nullopt;
  return std::exchange(newest_, std::nullopt);
}

void SetBuilder::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  ready_.notify_all();
}

SetBuilder::Counters SetBuilder::counters() const {
  const std::lock_guard lock(mutex_);
  Counters out = counters_;
  out.sync = sync_.stats();
  return out;
}

}  // namespace floatstage::studio
