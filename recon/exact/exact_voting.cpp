// Method:  the camera whose matte lacks what all others show, found
//          by leaving each out of a coarse hull
// Paper:   none
// Differs: a camera is left out whole, and only where without it most of what others miss comes back
// ADR:     0072

#include "recon/exact/exact_voting.h"

#include <algorithm>
#include <numeric>

#include "core/parallel.h"
#include "recon/mesh/mesh_mask.h"

namespace floatstage::recon {
namespace {

constexpr double kAllowed = 0.02;  // of a matte's subject
constexpr double kHealed = 0.2;    // of the excess that may remain without the guilty view
constexpr int kStep = 4;           // px between the pixels that are looked at
constexpr double kTolerance = 2;   // px, of the trial hulls' contours

/// The same camera with an image a quarter of the size: pixel (x, y) has the centre of pixel (4x + 1.5, 4y
/// + 1.5).
RigCamera coarse(const RigCamera& camera) {
  RigCamera out = camera;
  out.model.width = std::max(1, camera.model.width / kStep);
  out.model.height = std::max(1, camera.model.height / kStep);
  for (double* value : {&out.model.fx, &out.model.fy, &out.model.cx, &out.model.cy, &out.model.skew})
    *value /= kStep;
  return out;
}

double excess(std::span<const double> missed, int but_for) {
  double sum = 0;
  for (std::size_t c = 0; c < missed.size(); ++c) {
    if (static_cast<int>(c) != but_for) sum += std::max(0.0, missed[c] - kAllowed);
  }
  return sum;
}

Mesh to_mesh(const HullPolygons& polygons) {
  Mesh mesh;
  for (const Eigen::Vector3d& p : polygons.positions) mesh.positions.emplace_back(p.cast<float>());
  mesh.triangles = polygons.triangles;
  return mesh;
}

}  // namespace

std::vector<double> missed_shares(const Rig& rig, std::span<const Matte> mattes, const Mesh& mesh,
                                  int threads) {
  std::vector<double> missed(mattes.size(), 0);
  parallel_for(mattes.size(), threads, [&](std::size_t c) {
    if (mattes[c].empty()) return;
    const RigCamera small = coarse(rig.cameras[c]);
    const Matte hull = mesh_mask(small, mesh);
    int subject = 0, outside = 0;
    for (int y = 0; y < hull.height; ++y) {
      const std::uint8_t* row = mattes[c].row(std::min(kStep * y + kStep / 2, mattes[c].height - 1));
      for (int x = 0; x < hull.width; ++x) {
        if (row[std::min(kStep * x + kStep / 2, mattes[c].width - 1)] < 128) continue;
        ++subject;
        outside += hull.row(y)[x] == 0;
      }
    }
    missed[c] = subject > 0 ? static_cast<double>(outside) / subject : 0;
  });
  return missed;
}

namespace {

// The views of the hull once more, coarsely: what trials are made with.
void make_coarse_cones(const Rig& rig, HullInput& input, int threads, HullWorkspace::Impl& workspace) {
  SilhouetteCones& cones = workspace.coarse;
  ConeOptions settings;
  settings.tolerance = kTolerance;
  settings.threads = threads;
  workspace.builder.build(rig, input, settings, cones);
  // An outline may be too small for one tolerance and not for the other: only a view of the hull can be
  // guilty of it.
  for (std::size_t k = cones.views.size(); k-- > 0;) {
    const std::vector<int>& known = workspace.cones.camera;
    if (std::find(known.begin(), known.end(), cones.camera[k]) != known.end()) continue;
    cones.views.erase(cones.views.begin() + static_cast<std::ptrdiff_t>(k));
    cones.camera.erase(cones.camera.begin() + static_cast<std::ptrdiff_t>(k));
  }
  for (std::size_t v = 0; v < workspace.cones.views.size(); ++v) {
    if (workspace.cones.camera[v] >= 0) continue;  // the sides of the volume
    cones.views.push_back(workspace.cones.views[v]);
    cones.camera.push_back(-1);
  }
}

// The view without which the others miss least, if they miss less than with all.
struct Trial {
  int view = -1;
  double excess = 0;
  std::vector<double> missed;
};

Trial try_without_each(const Rig& rig, std::span<const Matte> mattes, double most, int threads,
                       HullWorkspace::Impl& workspace) {
  const SilhouetteCones& cones = workspace.coarse;
  Trial best{.excess = most, .missed = {}};
  for (std::size_t k = 0; k < cones.views.size(); ++k) {
    if (cones.camera[k] < 0 || cones.views.size() < 4) continue;
    workspace.views = cones.views;
    workspace.views.erase(workspace.views.begin() + static_cast<std::ptrdiff_t>(k));
    ExactOptions options;
    options.threads = threads;
    options.pixel = cones.pixel;
    if (!workspace.engine.compute(workspace.views, options).closed) continue;
    std::vector<double> missed = missed_shares(rig, mattes, to_mesh(workspace.engine.polygons()), threads);
    const double left = excess(missed, cones.camera[k]);
    if (left < best.excess) best = {static_cast<int>(k), left, std::move(missed)};
  }
  return best;
}

}  // namespace

std::vector<int> find_bad_views(const Rig& rig, HullInput& input, const Mesh& strict, int threads,
                                HullWorkspace::Impl& workspace) {
  const std::span<const Matte> mattes = input.mattes();
  std::vector<int> bad;
  std::vector<double> missed = missed_shares(rig, mattes, strict, threads);
  const auto in_doubt = [&] {
    const auto views =
        std::count_if(missed.begin(), missed.end(), [](double share) { return share > kAllowed; });
    return views >= std::max<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(mattes.size() + 1) / 2);
  };
  if (!in_doubt()) return bad;

  make_coarse_cones(rig, input, threads, workspace);
  SilhouetteCones& cones = workspace.coarse;
  const std::size_t most = std::max<std::size_t>(1, mattes.size() / 4);
  while (in_doubt() && bad.size() < most) {
    const double before = excess(missed, -1);
    Trial best = try_without_each(rig, mattes, before, threads, workspace);
    // What does not heal without one camera has another cause: calibration, or mattes that disagree a little
    // everywhere.
    if (best.view < 0 || best.excess > kHealed * before) break;
    bad.push_back(cones.camera[static_cast<std::size_t>(best.view)]);
    missed = std::move(best.missed);
    missed[static_cast<std::size_t>(bad.back())] = 0;
    cones.views.erase(cones.views.begin() + best.view);
    cones.camera.erase(cones.camera.begin() + best.view);
  }
  return bad;
}

}  // namespace floatstage::recon
