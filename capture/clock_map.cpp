#include "capture/clock_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"

namespace floatstage::capture {
namespace {

struct Point {
  double x = 0, y = 0;  // ns from the window's first sample: device time, and how much later the studio's is
};

// Positive when c lies above the line from a to b.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The lower convex hull of points that are sorted by x.
std::vector<Point> lower_hull(const std::vector<Point>& points) {
  std::vector<Point> hull;
  for (const Point& p : points) {
    while (hull.size() >= 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
    hull.push_back(p);
  }
  return hull;
}

}  // namespace

std::int64_t ClockMap::at(std::int64_t device) const {
  const std::int64_t elapsed = device - origin_.device;
  // The rate's distance from 1 is tiny: multiplying only that keeps nanoseconds over months.
  return origin_.arrival + elapsed + std::llround((rate_ - 1) * static_cast<double>(elapsed));
}

Timestamp ClockMap::observe(Nanoseconds device, Timestamp arrival) {
  const Sample sample{device.count, arrival.ns};
  if (!samples_.empty()) {
    const bool back = sample.device <= samples_.back().device;
    const bool early = sample.arrival < at(sample.device) - options_.step_bound.count;
    if (back || early) {
      samples_.clear();
      ++restarts_;
    }
  }
  samples_.push_back(sample);
  while (samples_.size() > options_.most_samples ||
         samples_.back().device - samples_.front().device > options_.window.count) {
    samples_.pop_front();
  }
  refit();
  return {std::min(at(sample.device), sample.arrival)};
}

void ClockMap::refit() {
  const Sample first = samples_.front();
  std::vector<Point> points;
  points.reserve(samples_.size());
  double mean = 0;
  for (const Sample& s : samples_) {
    const std::int64_t x = s.device - first.device;
    points.push_back({static_cast<double>(x), static_cast<double>(s.arrival - first.arrival - x)});
    mean += points.back().x / static_cast<double>(samples_.size());
  }
  const std::vector<Point> hull = lower_hull(points);
  double slope = 0;
  for (std::size_t i = 1; i < hull.size(); ++i) {
    if (hull[i].x < mean) continue;
    slope = (hull[i].y - hull[i - 1].y) / (hull[i].x - hull[i - 1].x);
    break;
  }
  slope = std::clamp(slope, -options_.rate_bound, options_.rate_bound);
  // The highest line of this slope that lies under every sample; also when the slope had to be clamped.
  double height = hull.front().y;
  for (const Point& p : hull) height = std::min(height, p.y - slope * p.x);
  rate_ = 1 + slope;
  origin_ = {first.device, first.arrival + std::llround(height)};
}

std::optional<Timestamp> ClockMap::map(Nanoseconds device) const {
  if (samples_.empty()) return std::nullopt;
  return Timestamp{at(device.count)};
}

ClockFit ClockMap::fit() const {
  ClockFit fit;
  fit.restarts = restarts_;
  fit.samples = samples_.size();
  if (samples_.empty()) return fit;
  fit.rate = rate_;
  fit.offset = {at(samples_.back().device) - samples_.back().device};
  std::vector<std::int64_t> delays;
  for (const Sample& s : samples_) delays.push_back(s.arrival - at(s.device));
  fit.delay_p50 = {median(delays)};
  fit.delay_p95 = {percentile(std::move(delays), 0.95)};
  return fit;
}

}  // namespace floatstage::capture
