// Method:  moves of rays and centres by hashes, and the same numbers on an integer grid
// Paper:   after H. Edelsbrunner, E. P. Mücke, "Simulation of simplicity", 1990
// Differs: the move is real and tiny (1e-4 px), not symbolic; a predicate that is still zero asks for
//          another hash
// ADR:     0071

#include "recon/exact/exact_views.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace floatstage::recon {
namespace {

double signed_unit(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::uint64_t h = mix(mix(mix(mix(seed) ^ a) ^ b) ^ c);
  return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

}  // namespace

void ConeView::clear() {
  rays.clear();
  next.clear();
  prev.clear();
  loop.clear();
  beyond_counts = mandatory = false;
}

void perturb(std::span<ConeView> views, const Perturbation& perturbation) {
  if (perturbation.seed == 0) return;
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      views[v].center[axis] += perturbation.center * signed_unit(perturbation.seed, v, ~std::uint64_t{0},
                                                                 static_cast<std::uint64_t>(axis));
    }
    for (std::size_t r = 0; r < views[v].rays.size(); ++r) {
      for (int axis = 0; axis < 3; ++axis) {
        views[v].rays[r][axis] +=
            perturbation.ray * signed_unit(perturbation.seed, v, r, static_cast<std::uint64_t>(axis));
      }
    }
  }
}

bool snap_to_grid(std::span<ConeView> views, GridViews& grid) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ConeView& view : views) mean += view.center / static_cast<double>(views.size());
  double spread = 0, longest = 0;
  for (const ConeView& view : views) {
    spread = std::max(spread, (view.center - mean).cwiseAbs().maxCoeff());
    for (const Eigen::Vector3d& ray : view.rays) longest = std::max(longest, ray.cwiseAbs().maxCoeff());
  }
  if (!(spread > 0) || !(longest > 0) || !std::isfinite(spread) || !std::isfinite(longest)) return false;
  // Powers of two: the rounded numbers are exact doubles again.
  grid.center_scale = std::exp2(std::floor(std::log2(0x1p26 / spread)));
  grid.ray_scale = std::exp2(std::floor(std::log2(0x1p28 / longest)));
  grid.centers.resize(views.size());
  grid.rays.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double rounded = std::nearbyint((views[v].center[axis] - mean[axis]) * grid.center_scale);
      grid.centers[v][axis] = static_cast<std::int64_t>(rounded);
      views[v].center[axis] = mean[axis] + rounded / grid.center_scale;
    }
    grid.rays[v].resize(views[v].rays.size());
    for (std::size_t r = 0; r < views[v].rays.size(); ++r) {
      for (int axis = 0; axis < 3; ++axis) {
        const double rounded = std::nearbyint(views[v].rays[r][axis] * grid.ray_scale);
        grid.rays[v][r][axis] = static_cast<std::int64_t>(rounded);
        views[v].rays[r][axis] = rounded / grid.ray_scale;
      }
    }
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t u = 0; u < v; ++u) {
      if (grid.centers[u] == grid.centers[v]) return false;
    }
  }
  return true;
}

std::array<ConeView, 2> volume_views(const Eigen::AlignedBox3d& box) {
  // Spread so little that the box grows by a hundred-thousandth, and unevenly: exact right angles between the
  // views of one box would be degenerate.
  constexpr double kSpread = 1e-5;
  std::array<ConeView, 2> out;
  for (int k = 0; k < 2; ++k) {
    const double inward = k == 0 ? 1 : -1;
    out[k].center = k == 0 ? box.min() : box.max();
    std::array<Eigen::Vector3d, 3> rays;
    for (int axis = 0; axis < 3; ++axis) {
      rays[axis][axis] = inward;
      rays[axis][(axis + 1) % 3] = -inward * kSpread * (1 + 0.11 * axis + 0.05 * k);
      rays[axis][(axis + 2) % 3] = -inward * kSpread * (1 + 0.07 * axis + 0.03 * k);
    }
    if (rays[0].cross(rays[1]).dot(rays[2]) < 0) std::swap(rays[0], rays[1]);
    out[k].mandatory = true;
    out[k].add_loop(rays);
  }
  return out;
}

}  // namespace floatstage::recon
