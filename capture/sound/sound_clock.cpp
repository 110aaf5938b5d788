#include "capture/sound/sound_clock.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/statistics.h"

namespace floatstage::capture {
namespace {

constexpr double kUsualPpm = 100;     // what crystals keep
constexpr double kMostPpm = 1000;     // of any clock that we believe
constexpr double kTukey = 4.685;      // 95 % efficient where errors are Gaussian
constexpr double kGaussian = 1.483;   // of a median distance, to one standard deviation
constexpr double kLeastJitter = 1e3;  // ns: no system's clock is read more exactly
constexpr int kRounds = 20;

struct Line {
  double height = 0, slope = 0;  // late = height + slope x
};

// x: ns by the nominal rate since the run's first stamp; y: how much later than that the stamp is.
struct Point {
  double x = 0, y = 0;
};

double scatter(std::span<const Point> points, const Line& line) {
  std::vector<double> distances;
  for (const Point& p : points) distances.push_back(std::abs(p.y - line.height - line.slope * p.x));
  return median(std::move(distances));
}

// Through the medians of the first and the last third, so that the first weights are no worse than halves.
Line rough(std::span<const Point> points) {
  const std::size_t third = points.size() / 3;
  auto middle = [](std::span<const Point> of) {
    std::vector<double> x, y;
    for (const Point& p : of) x.push_back(p.x), y.push_back(p.y);
    return Point{median(std::move(x)), median(std::move(y))};
  };
  Line line;
  if (third > 0) {
    const Point a = middle(points.first(third)), b = middle(points.last(third));
    line.slope = std::clamp((b.y - a.y) / (b.x - a.x), -kMostPpm * 1e-6, kMostPpm * 1e-6);
  }
  std::vector<double> heights;
  for (const Point& p : points) heights.push_back(p.y - line.slope * p.x);
  line.height = median(std::move(heights));
  return line;
}

// One round of weighted least squares, with the clock's own prior.
Line refitted(std::span<const Point> points, const Line& line, double sigma) {
  double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (const Point& p : points) {
    const double u = (p.y - line.height - line.slope * p.x) / (kTukey * sigma);
    const double weight = std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0;
    w += weight, wx += weight * p.x, wy += weight * p.y;
    wxx += weight * p.x * p.x, wxy += weight * p.x * p.y;
  }
  if (w <= 0) return line;
  const double prior = sigma / (kUsualPpm * 1e-6);
  const double mean = wx / w, spread = wxx - wx * mean + prior * prior;
  const double slope = std::clamp((wxy - wx * wy / w) / spread, -kMostPpm * 1e-6, kMostPpm * 1e-6);
  return {wy / w - slope * mean, slope};
}

}  // namespace

SoundClock::SoundClock(const std::vector<SoundStamp>& stamps, int nominal_rate, std::int64_t samples) {
  if (!stamps.empty()) origin_ = stamps.front().time;
  const double period = 1e9 / nominal_rate;
  for (auto begin = stamps.begin(); begin != stamps.end();) {
    const auto end =
        std::find_if(begin, stamps.end(), [&](const SoundStamp& s) { return s.run != begin->run; });
    SoundRun run;
    run.first = begin->sample;
    run.end = end == stamps.end() ? samples : std::min(end->sample, samples);
    const double start = static_cast<double>((begin->time - origin_).count);
    std::vector<Point> points;
    for (auto s = begin; s != end && s->sample <= samples; ++s) {
      const double x = static_cast<double>(s->sample - run.first) * period;
      points.push_back({x, static_cast<double>((s->time - origin_).count) - start - x});
    }
    begin = end;
    if (run.end <= run.first) continue;
    Line line = rough(points);
    for (int i = 0; i < kRounds && points.size() > 1; ++i)
      line = refitted(points, line, std::max(kLeastJitter, kGaussian * scatter(points, line)));
    run.jitter_ns = scatter(points, line);
    run.start_ns = start + line.height;
    run.rate = nominal_rate / (1 + line.slope);
    run.ppm = (1 / (1 + line.slope) - 1) * 1e6;
    runs_.push_back(run);
  }
}

Timestamp SoundClock::start_of(const SoundRun& run) const {
  return origin_ + Nanoseconds{std::llround(run.start_ns)};
}

Timestamp SoundClock::end_of(const SoundRun& run) const {
  return origin_ +
         Nanoseconds{std::llround(run.start_ns + static_cast<double>(run.end - run.first) / run.rate * 1e9)};
}

double SoundClock::sample_at(const SoundRun& run, Timestamp time) const {
  return static_cast<double>(run.first) +
         (static_cast<double>((time - origin_).count) - run.start_ns) * 1e-9 * run.rate;
}

std::optional<Timestamp> SoundClock::time_of(std::int64_t sample) const {
  if (runs_.empty()) return std::nullopt;
  const SoundRun* of = &runs_.front();
  for (const SoundRun& run : runs_)
    if (run.first <= sample) of = &run;
  return origin_ +
         Nanoseconds{std::llround(of->start_ns + static_cast<double>(sample - of->first) / of->rate * 1e9)};
}

}  // namespace floatstage::capture
