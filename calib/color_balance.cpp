#include "calib/color_balance.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using ByPoint = std::map<int, std::vector<const ColorSample*>>;

// What the cameras that are done, but `camera`, make of a point.
std::optional<Eigen::Vector3d> others(const std::vector<const ColorSample*>& sights, int camera,
                                      const std::vector<std::optional<ColorTransform>>& done) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const ColorSample* s : sights)
    if (s->camera != camera && done[at(s->camera)]) {
      sum += apply(*done[at(s->camera)], s->seen);
      ++count;
    }
  if (count == 0) return std::nullopt;
  return sum / count;
}

std::vector<ColorPair> pairs_of(const ByPoint& points, int camera,
                                const std::vector<std::optional<ColorTransform>>& done) {
  std::vector<ColorPair> pairs;
  for (const auto& [point, sights] : points)
    for (const ColorSample* s : sights)
      if (s->camera == camera)
        if (const std::optional<Eigen::Vector3d> wanted = others(sights, camera, done))
          pairs.push_back({s->seen, wanted->cwiseMax(0.0).cwiseMin(1.0)});
  return pairs;
}

bool well_exposed(const Eigen::Vector3d& rgb) { return rgb.minCoeff() >= 0.01 && rgb.maxCoeff() <= 0.99; }

ColorAgreement judge(const ByPoint& points, int camera,
                     const std::vector<std::optional<ColorTransform>>& transforms) {
  const std::vector<std::optional<ColorTransform>> none(transforms.size(), ColorTransform{});
  std::vector<double> before, after;
  for (const auto& [point, sights] : points)
    for (const ColorSample* s : sights) {
      if (s->camera != camera || !well_exposed(s->seen)) continue;
      const std::optional<Eigen::Vector3d> raw = others(sights, camera, none),
                                           wanted = others(sights, camera, transforms);
      if (!raw || !wanted) continue;
      before.push_back(delta_e_2000(lab_from_srgb(s->seen), lab_from_srgb(*raw)));
      after.push_back(
          delta_e_2000(lab_from_srgb(apply(*transforms[at(camera)], s->seen)), lab_from_srgb(*wanted)));
    }
  ColorAgreement a;
  if (after.empty()) return a;
  const double limit = 2 + 4 * median(after);
  std::vector<double> kept;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i] > limit) {
      ++a.strays;
      continue;
    }
    kept.push_back(after[i]);
    a.mean_after += after[i];
    a.mean_before += before[i];
  }
  a.points = static_cast<int>(kept.size());
  a.mean_after /= a.points;
  a.mean_before /= a.points;
  a.p95_after = percentile(std::move(kept), 0.95);
  return a;
}

}  // namespace

Result<ColorBalance> balance_colors(std::span<const ColorSample> sights,
                                    const std::vector<std::optional<ColorTransform>>& given,
                                    const std::vector<std::string>& serials) {
  FLOATSTAGE_CHECK(given.size() == serials.size(), "one transform and one serial a camera");
  ByPoint points;
  for (const ColorSample& s : sights) points[s.point].push_back(&s);
  std::vector<std::optional<ColorTransform>> done = given;
  const auto count = static_cast<int>(serials.size());
  if (std::none_of(given.begin(), given.end(), [](const auto& t) { return t.has_value(); }))
    return fail(ErrorCode::InvalidArgument, "colours need one camera that the others are to look like");
  const auto fit = [&](int camera) -> Result<void> {
    const std::vector<ColorPair> pairs = pairs_of(points, camera, done);
    const Result<ColorFit> fitted = fit_color(pairs);
    if (!fitted)
      return fail(ErrorCode::BadData, text("camera '", serials[at(camera)], "' shares ", pairs.size(),
                                           " surface points with the others: ", fitted.error().message));
    done[at(camera)] = fitted->transform;
    return {};
  };
  for (;;) {
    int next = -1;
    std::size_t most = 0;
    for (int c = 0; c < count; ++c) {
      if (done[at(c)]) continue;
      const std::size_t shared = pairs_of(points, c, done).size();
      if (next < 0 || shared > most) next = c, most = shared;
    }
    if (next < 0) break;
    if (const Result<void> ok = fit(next); !ok) return forward(ok);
  }
  for (int round = 0; round < 2; ++round)
    for (int c = 0; c < count; ++c)
      if (!given[at(c)])
        if (const Result<void> ok = fit(c); !ok) return forward(ok);
  ColorBalance out;
  for (int c = 0; c < count; ++c) {
    out.transforms.push_back(*done[at(c)]);
    out.cameras.push_back(judge(points, c, done));
  }
  return out;
}

}  // namespace floatstage::calib
