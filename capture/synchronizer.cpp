#include "capture/synchronizer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

// The loop's gains: how much of a set's surprise goes into the phase and into the period. Critically damped
// (beta = alpha^2 / (2 - alpha)), fast enough for 1 % of error in the nominal rate.
constexpr double kPhaseGain = 0.5;
constexpr double kPeriodGain = kPhaseGain * kPhaseGain / (2 - kPhaseGain);
// The period never strays further from the nominal one than a camera's clock can.
constexpr double kPeriodBound = 0.02;

}  // namespace

Result<Synchronizer> Synchronizer::make(int cameras, const SyncOptions& options) {
  if (cameras < 1) return fail(ErrorCode::InvalidArgument, "synchroniser: there is no camera to group");
  if (!(options.frame_rate > 0) || !std::isfinite(options.frame_rate)) {
    return fail(ErrorCode::InvalidArgument,
                text("synchroniser: a frame rate of ", options.frame_rate,
                     " cannot be; give the cameras' common rate in frames a second"));
  }
  const double half_ms = 500 / options.frame_rate;
  if (options.tolerance.count < 0 || static_cast<double>(options.tolerance.count) * 1e-6 >= half_ms) {
    return fail(ErrorCode::InvalidArgument,
                text("synchroniser: a tolerance of ", static_cast<double>(options.tolerance.count) * 1e-6,
                     " ms does not fit ", options.frame_rate,
                     " frames a second; it must be below half a period, ", half_ms, " ms"));
  }
  if (!options.offsets.empty() && options.offsets.size() != static_cast<std::size_t>(cameras))
    return fail(ErrorCode::InvalidArgument,
                text("synchroniser: ", options.offsets.size(), " time offsets for ", cameras, " cameras"));
  return Synchronizer(cameras, options);
}

Synchronizer::Synchronizer(int cameras, const SyncOptions& options)
    : options_(options), nominal_period_(1e9 / options.frame_rate), period_(nominal_period_) {
  lanes_.resize(static_cast<std::size_t>(cameras));
}

std::int64_t Synchronizer::instant_of(const Frame& frame) const {
  const std::int64_t stamp = frame.info.exposure_start.ns;
  return options_.offsets.empty()
             ? stamp
             : stamp + options_.offsets[static_cast<std::size_t>(frame.info.camera)].count;
}

void Synchronizer::push(Frame frame) {
  const int camera = frame.info.camera;
  FLOATSTAGE_CHECK(camera >= 0 && camera < static_cast<int>(lanes_.size()),
                   "a frame of no camera of the rig");
  if (frame.empty() || frame.info.status == FrameStatus::Lost) return;
  Lane& lane = lanes_[static_cast<std::size_t>(camera)];
  const bool gone = begun_ && static_cast<double>(instant_of(frame) - base_) < gone_;
  const bool back =
      !lane.waiting.empty() && frame.info.exposure_start < lane.waiting.back().info.exposure_start;
  if (gone || back) {
    ++lane.counts.late;
    return;
  }
  lane.waiting.push_back(std::move(frame));
}

// The first instant is that of the earliest frame, once every camera has shown one or has had its time.
bool Synchronizer::begin(Timestamp now, Wait wait) {
  if (begun_) return true;
  bool all = true;
  std::optional<Timestamp> earliest;
  for (const Lane& lane : lanes_) {
    if (lane.waiting.empty()) {
      all = false;
    } else {
      const Timestamp time{instant_of(lane.waiting.front())};
      earliest = earliest ? std::min(*earliest, time) : time;
    }
  }
  if (!earliest) return false;
  if (!all && wait == Wait::UntilLate && now - *earliest < options_.longest_wait) return false;
  base_ = earliest->ns;
  expected_ = 0;
  gone_ = -half_period();
  begun_ = true;
  return true;
}

bool Synchronizer::is_settled(Timestamp now, Wait wait) const {
  if (wait == Wait::NotAtAll) return true;
  if (static_cast<double>(now.ns - base_) >= expected_ + static_cast<double>(options_.longest_wait.count))
    return true;
  return std::all_of(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return !lane.waiting.empty(); });
}

// Where every camera skipped an instant, there is no set to wait for.
void Synchronizer::skip_empty_instants() {
  double earliest = 0;
  bool any = false;
  for (const Lane& lane : lanes_) {
    if (lane.waiting.empty()) continue;
    const double time = static_cast<double>(instant_of(lane.waiting.front()) - base_);
    earliest = any ? std::min(earliest, time) : time;
    any = true;
  }
  if (!any || earliest < expected_ + half_period()) return;
  const double periods = std::floor((earliest - expected_) / period_ + 0.5);
  totals_.skipped += static_cast<std::uint64_t>(periods);
  expected_ += periods * period_;
}

FrameSet Synchronizer::take_set() {
  const double end = expected_ + half_period();
  const auto time_of = [&](const Frame& f) { return static_cast<double>(instant_of(f) - base_); };
  FrameSet set;
  set.frames.resize(lanes_.size());
  std::vector<double> times;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Lane& lane = lanes_[i];
    // Of several frames within one period, the one nearest to the epoch is the camera's.
    while (!lane.waiting.empty() && time_of(lane.waiting.front()) < end) {
      Frame& frame = lane.waiting.front();
      if (!set.frames[i].empty()) ++lane.counts.duplicates;
      if (set.frames[i].empty() ||
          std::abs(time_of(frame) - expected_) < std::abs(time_of(set.frames[i]) - expected_)) {
        set.frames[i] = std::move(frame);
      }
      lane.waiting.pop_front();
    }
    if (!set.frames[i].empty()) times.push_back(time_of(set.frames[i]));
  }
  gone_ = end;
  if (times.empty()) return set;

  const double middle = median(std::move(times));
  double first = middle, last = middle;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    if (set.frames[i].empty()) continue;
    const double time = time_of(set.frames[i]);
    lanes_[i].offsets_ns += time - middle;
    ++lanes_[i].measured;
    if (std::abs(time - middle) > static_cast<double>(options_.tolerance.count)) {
      ++lanes_[i].counts.out_of_tolerance;
      set.frames[i] = {};
      continue;
    }
    first = std::min(first, time);
    last = std::max(last, time);
  }
  set.time = {base_ + std::llround(middle)};
  spreads_.add(std::llround(last - first));
  follow(middle);
  return set;
}

void Synchronizer::follow(double middle) {
  const double surprise = middle - expected_;
  period_ = std::clamp(period_ + kPeriodGain * surprise, nominal_period_ * (1 - kPeriodBound),
                       nominal_period_ * (1 + kPeriodBound));
  expected_ += kPhaseGain * surprise + period_;
  gone_ = std::min(gone_, expected_ - half_period());
}

std::optional<FrameSet> Synchronizer::settle(Timestamp now, Wait wait) {
  if (!begin(now, wait)) return std::nullopt;
  const bool any =
      std::any_of(lanes_.begin(), lanes_.end(), [](const Lane& l) { return !l.waiting.empty(); });
  if (!any || !is_settled(now, wait)) return std::nullopt;
  skip_empty_instants();
  FrameSet set = take_set();
  bool complete = true;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    complete = complete && !set.frames[i].empty();
    ++(set.frames[i].empty() ? lanes_[i].counts.missing : lanes_[i].counts.used);
  }
  ++(complete ? totals_.complete : totals_.incomplete);
  return set;
}

std::optional<FrameSet> Synchronizer::next(Timestamp now) { return settle(now, Wait::UntilLate); }

std::optional<FrameSet> Synchronizer::drain() { return settle({}, Wait::NotAtAll); }

SyncStats Synchronizer::stats() const {
  SyncStats stats = totals_;
  if (!spreads_.empty()) {
    stats.spread_p50_ms = static_cast<double>(spreads_.percentile(0.5)) * 1e-6;
    stats.spread_p99_ms = static_cast<double>(spreads_.percentile(0.99)) * 1e-6;
    stats.spread_max_ms = static_cast<double>(spreads_.percentile(1)) * 1e-6;
  }
  for (const Lane& lane : lanes_) {
    stats.cameras.push_back(lane.counts);
    if (lane.measured > 0) {
      stats.cameras.back().mean_offset_ms = lane.offsets_ns / static_cast<double>(lane.measured) * 1e-6;
    }
  }
  return stats;
}

SyncStats Synchronizer::take_stats() {
  const SyncStats taken = stats();
  totals_ = {};
  spreads_.clear();
  for (Lane& lane : lanes_) {
    lane.counts = {};
    lane.offsets_ns = 0;
    lane.measured = 0;
  }
  return taken;
}

std::vector<std::string> sync_complaints(const SyncStats& stats, const std::vector<std::string>& serials,
                                         const SyncLimits& limits) {
  FLOATSTAGE_CHECK(serials.size() == stats.cameras.size(), "one serial for each camera");
  std::vector<std::string> complaints;
  for (std::size_t i = 0; i < serials.size(); ++i) {
    const CameraSync& camera = stats.cameras[i];
    if (camera.used == 0) {
      complaints.push_back(text("camera '", serials[i], "': none of its frames is in any set; ",
                                camera.out_of_tolerance > 0
                                    ? text("its exposures are ", camera.mean_offset_ms,
                                           " ms from the others': check its trigger or its clock")
                                    : std::string("check its cable and its trigger")));
    } else if (camera.missing > limits.missing_frames) {
      complaints.push_back(text("camera '", serials[i], "': missing in ", camera.missing, " sets (",
                                camera.late, " frames came late, ", camera.out_of_tolerance,
                                " were out of tolerance); check its link and its trigger"));
    }
  }
  if (stats.spread_max_ms > limits.spread_ms) {
    complaints.push_back(text("the exposures of one instant lie up to ", stats.spread_max_ms,
                              " ms apart; at most ", limits.spread_ms,
                              " ms are allowed: trigger the cameras together"));
  }
  return complaints;
}

}  // namespace floatstage::capture
