#include "core/synthetic/shell.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;

Section catmull_rom(const std::vector<Section>& s, std::size_t i, double t) {
  const Section &p0 = s[i > 0 ? i - 1 : 0], &p1 = s[i], &p2 = s[i + 1],
                &p3 = s[std::min(i + 2, s.size() - 1)];
  auto at = [&](double Section::*m) {
    const double a = p0.*m, b = p1.*m, c = p2.*m, d = p3.*m;
    // Kept between its two ends: an overshoot would make a bulge that nobody drew.
    const double v = b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
    return std::clamp(v, std::min(b, c), std::max(b, c));
  };
  return {p1.z + t * (p2.z - p1.z), at(&Section::a), at(&Section::b), at(&Section::y)};
}

// Rings of `segments` points between two poles, in ascending order.
Shell close_rings(int rings, int segments, const std::function<Vector3d(int ring, int segment)>& point,
                  const Vector3d& low, const Vector3d& high) {
  Shell shell;
  shell.rest.push_back(low);
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < segments; ++s) shell.rest.push_back(point(r, s));
  shell.rest.push_back(high);
  auto index = [&](int r, int s) { return static_cast<std::uint32_t>(1 + r * segments + s % segments); };
  const auto last = static_cast<std::uint32_t>(shell.rest.size() - 1);
  auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    shell.triangles.insert(shell.triangles.end(), {a, b, c});
  };
  for (int s = 0; s < segments; ++s) add(0, index(0, s + 1), index(0, s));
  for (int r = 0; r + 1 < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      add(index(r, s), index(r, s + 1), index(r + 1, s + 1));
      add(index(r, s), index(r + 1, s + 1), index(r + 1, s));
    }
  }
  for (int s = 0; s < segments; ++s) add(last, index(rings - 1, s), index(rings - 1, s + 1));
  return shell;
}

double signed_power(double v, double exponent) { return std::copysign(std::pow(std::abs(v), exponent), v); }

}  // namespace

Shell tube(const std::vector<Section>& sections, const TubeOptions& options) {
  FLOATSTAGE_CHECK(sections.size() >= 2 && options.segments >= 3,
                   "a tube needs two sections and three segments");
  std::vector<Section> rings;
  const double length = sections.back().z - sections.front().z;
  constexpr int kCapRings = 4;
  auto cap = [&](const Section& end, double reach,
                 int k) {  // k = 0 at the end section … kCapRings near the pole
    const double angle = k * std::numbers::pi / 2 / (kCapRings + 1);
    return Section{end.z + reach * std::sin(angle), end.a * std::cos(angle), end.b * std::cos(angle), end.y};
  };
  for (int k = kCapRings; k > 0; --k) rings.push_back(cap(sections.front(), -options.near_cap, k));
  for (std::size_t i = 0; i + 1 < sections.size(); ++i) {
    const double share = (sections[i + 1].z - sections[i].z) / length;
    const int steps = std::max(1, static_cast<int>(std::lround(share * options.rings)));
    for (int k = 0; k < steps; ++k) rings.push_back(catmull_rom(sections, i, static_cast<double>(k) / steps));
  }
  for (int k = 0; k <= kCapRings; ++k) rings.push_back(cap(sections.back(), options.far_cap, k));
  const double power = 2 / options.exponent;
  auto point = [&](int r, int s) {
    const Section& ring = rings[static_cast<std::size_t>(r)];
    const double angle = 2 * std::numbers::pi * s / options.segments;
    return Vector3d(ring.a * signed_power(std::cos(angle), power),
                    ring.y + ring.b * signed_power(std::sin(angle), power), ring.z);
  };
  return close_rings(static_cast<int>(rings.size()), options.segments, point,
                     {0, sections.front().y, sections.front().z - options.near_cap},
                     {0, sections.back().y, sections.back().z + options.far_cap});
}

Shell blob(int rings, int segments, const std::function<Vector3d(const Vector3d&)>& place) {
  auto point = [&](int r, int s) {
    const double polar = std::numbers::pi * (r + 1) / (rings + 1),
                 azimuth = 2 * std::numbers::pi * s / segments;
    return place(
        {std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), -std::cos(polar)});
  };
  return close_rings(rings, segments, point, place(-Vector3d::UnitZ()), place(Vector3d::UnitZ()));
}

Shell moved(Shell shell, const std::function<Vector3d(const Vector3d&)>& where) {
  for (Vector3d& p : shell.rest) p = where(p);
  return shell;
}

}  // namespace floatstage::synthetic
