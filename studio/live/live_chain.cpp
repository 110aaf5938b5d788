#include "studio/live/live_chain.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"
#include "core/text.h"
#include "studio/live/live_quality.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

constexpr double kSmoothing = 0.2;               // weight of the newest duration
constexpr double kMargin = 3;                    // ms by which a scene should be early
constexpr Nanoseconds kLook = milliseconds(50);  // how often an idle chain looks whether it is to end

std::chrono::steady_clock::time_point time_point(Timestamp t) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(t.ns));
}

void smooth(double& mean, double value) { mean = mean == 0 ? value : mean + kSmoothing * (value - mean); }

}  // namespace

Result<std::unique_ptr<LiveChain>> LiveChain::make(LiveSource& source, const LiveChainOptions& options) {
  Result<CameraRack> rack = CameraRack::make(source.rig(), options.key, source.samples());
  if (!rack) return forward(rack);
  for (const LiveQuality& quality : live_qualities())  // a change of quality must not cost a picture
    if (Result<void> ok = rack->prepare(quality.node.shrink); !ok) return forward(ok);
  capture::SyncOptions sync;
  sync.frame_rate = source.frame_rate();
  sync.tolerance = std::min(options.tolerance, Nanoseconds{std::llround(4e8 / source.frame_rate())});
  sync.longest_wait = options.longest_wait;
  sync.offsets = source.time_offsets();
  Result<std::unique_ptr<SetBuilder>> sets =
      SetBuilder::make(static_cast<int>(source.rig().cameras.size()), sync);
  if (!sets) return forward(sets);
  return std::unique_ptr<LiveChain>(new LiveChain(source, options, std::move(*rack), std::move(*sets)));
}

std::string LiveChain::description() const { return text(source_.description(), "; keyed by ", keys_); }

void LiveChain::begin() {
  thread_ = std::thread([this] { run(); });
  source_.begin([this](const Frame& frame, Timestamp produced) { sets_->push(frame, produced); });
}

void LiveChain::end() {
  source_.stop();
  sets_->close();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Timestamp LiveChain::start_of_work() const {
  if (!drawing_since_) return {};
  const double begin_ms = draws_ms_ - makes_ms_ - kMargin;
  return *drawing_since_ + Nanoseconds{std::llround(std::max(begin_ms, 0.0) * 1e6)};
}

// Until the last scene was fetched and the view will soon be ready for another.
bool LiveChain::wait_for_demand() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (next_) {
      changed_.wait(lock);
      continue;
    }
    const Timestamp start = start_of_work();
    if (now() >= start) return true;
    changed_.wait_until(lock, time_point(start));
  }
  return false;
}

void LiveChain::run() {
  while (wait_for_demand()) {
    const std::optional<TimedSet> set = sets_->newest(now() + kLook);
    if (set) {
      make_scene(*set);
    } else if (source_.over()) {
      const std::lock_guard lock(mutex_);
      over_ = true;
      changed_.notify_all();
      return;
    }
  }
}

void LiveChain::make_scene(const TimedSet& set) {
  const Timestamp begun = now();
  NodeQuality quality;
  {
    const std::lock_guard lock(mutex_);
    quality = quality_;
    textured_now_ = textured_;
    working_ = true;
  }
  std::shared_ptr<LiveScene> scene = scenes_.take();
  scene->times = {};
  scene->times.wait = milliseconds_of(begun - set.first_produced);
  rack_.look(set, textured_now_, quality, options_.threads, scene->times, scene->views);
  const Timestamp looked = now();
  const Result<void> made = reconstruction_.make(scene->views, options_.threads, scene->scene);
  scene->ready = now();
  scene->times.hull = milliseconds_of(scene->ready - looked);
  if (made) watch_.offer(reconstruction_.outlines(), set.images.frames);
  set_remark(!rack_.trouble().empty()            ? rack_.trouble()
             : !made                             ? made.error().message
             : !reconstruction_.remark().empty() ? reconstruction_.remark()
                                                 : watch_.news()->remark());

  const std::lock_guard lock(mutex_);
  working_ = false;
  smooth(makes_ms_, milliseconds_of(scene->ready - begun));
  counters_.busy_seconds += seconds(scene->ready - begun);
  if (!rack_.trouble().empty()) ++counters_.troubled;
  if (!made) {
    ++counters_.failed;
    return;
  }
  ++counters_.scenes;
  if (next_) ++counters_.unseen;
  next_ = std::move(scene);
  changed_.notify_all();
}

void LiveChain::set_remark(const std::string& remark) {
  {
    const std::lock_guard lock(mutex_);
    if (remark == remark_) return;
    remark_ = remark;
  }
  if (!remark.empty()) log::warning(remark);
}

std::shared_ptr<const LiveScene> LiveChain::newest(Timestamp deadline) {
  std::shared_ptr<const LiveScene> scene;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, time_point(deadline), [&] { return next_ || over_ || stopping_; });
    scene = std::exchange(next_, nullptr);
  }
  changed_.notify_all();
  return scene;
}

bool LiveChain::over() const {
  const std::lock_guard lock(mutex_);
  return over_ && !next_;
}

void LiveChain::drawing(Timestamp begun) {
  {
    const std::lock_guard lock(mutex_);
    drawing_since_ = begun;
  }
  changed_.notify_all();
}

void LiveChain::drawn(Timestamp ended) {
  {
    const std::lock_guard lock(mutex_);
    if (drawing_since_) smooth(draws_ms_, milliseconds_of(ended - *drawing_since_));
    drawing_since_.reset();
  }
  changed_.notify_all();
}

bool LiveChain::working() const {
  const std::lock_guard lock(mutex_);
  return working_;
}

void LiveChain::want(const std::vector<int>& cameras) {
  const std::lock_guard lock(mutex_);
  textured_.assign(rig().cameras.size(), false);
  for (int camera : cameras) textured_[static_cast<std::size_t>(camera)] = true;
}

void LiveChain::set_quality(const NodeQuality& quality) {
  const std::lock_guard lock(mutex_);
  quality_ = quality;
}

LiveChain::Counters LiveChain::counters() const {
  const SetBuilder::Counters sets = sets_->counters();
  const std::lock_guard lock(mutex_);
  Counters out = counters_;
  out.sets = sets;
  return out;
}

std::string LiveChain::remark() const {
  const std::lock_guard lock(mutex_);
  return remark_;
}

}  // namespace floatstage::studio
