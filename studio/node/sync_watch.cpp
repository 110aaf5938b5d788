#include "studio/node/sync_watch.h"

#include <algorithm>
#include <utility>

namespace floatstage::studio {
namespace {

constexpr Nanoseconds kWindow = milliseconds(1000);
constexpr Nanoseconds kFirstWindow = milliseconds(500);

}  // namespace

Result<std::unique_ptr<SyncWatch>> SyncWatch::make(std::vector<std::string> serials, double frame_rate,
                                                   const capture::SyncLimits& limits,
                                                   std::vector<Nanoseconds> offsets) {
  capture::SyncOptions options;
  options.offsets = std::move(offsets);
  options.frame_rate = frame_rate;
  options.tolerance.count = std::min(options.tolerance.count, static_cast<std::int64_t>(0.4e9 / frame_rate));
  Result<capture::Synchronizer> synchronizer =
      capture::Synchronizer::make(static_cast<int>(serials.size()), options);
  if (!synchronizer) return forward(synchronizer);
  return std::unique_ptr<SyncWatch>(new SyncWatch(std::move(serials), limits, std::move(*synchronizer)));
}

SyncWatch::SyncWatch(std::vector<std::string> serials, const capture::SyncLimits& limits,
                     capture::Synchronizer synchronizer)
    : serials_(std::move(serials)), limits_(limits), synchronizer_(std::move(synchronizer)) {}

void SyncWatch::push(const FrameInfo& info) {
  Frame frame;
  frame.info = info;
  frame.pixels = picture_;
  std::lock_guard lock(mutex_);
  synchronizer_.push(std::move(frame));
}

void SyncWatch::look(Timestamp now) {
  std::lock_guard lock(mutex_);
  while (synchronizer_.next(now)) {
  }
  if (begun_ == Timestamp{}) begun_ = now;
  if (now - begun_ < (settled_ ? kWindow : kFirstWindow)) return;
  begun_ = now;
  const capture::SyncStats stats = synchronizer_.take_stats();
  if (std::exchange(settled_, true))
    seen_ = {stats.spread_p50_ms, stats.spread_max_ms, capture::sync_complaints(stats, serials_, limits_),
             true};
}

SyncWatch::Seen SyncWatch::last() const {
  std::lock_guard lock(mutex_);
  return seen_;
}

}  // namespace floatstage::studio
