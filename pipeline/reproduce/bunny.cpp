#include "pipeline/reproduce/bunny.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/random.h"
#include "core/synthetic/mesh_photograph.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr double kDistance = 0.45;                                     // metres
constexpr double kFocal = 1150, kSize = 512;                           // px
constexpr double kMiddleElevation = 15, kLowest = -20, kHighest = 70;  // degrees
constexpr float kCell = 0.006F;                                        // metres
constexpr std::uint64_t kPaint = 7;
constexpr int kRays = 3;  // a pixel, along each side
constexpr int kCandidates = 4000;
constexpr double kApart = 15;  // degrees

const Eigen::Vector3d kMiddle(-0.017, 0.11, 0);  // the scan's world is y up

}  // namespace

Result<Bunny> load_bunny(const std::filesystem::path& folder) {
  Result<Mesh> exact = load_ply(folder / "bun_zipper.ply");
  if (!exact) return forward(exact);
  Result<Mesh> coarse = load_ply(folder / "bun_zipper_res4.ply");
  if (!coarse) return forward(coarse);
  return Bunny{std::move(*exact), std::move(*coarse)};
}

RigCamera bunny_camera(double azimuth, double elevation, int size) {
  const double a = azimuth * kRadian, e = elevation * kRadian;
  RigCamera camera;
  camera.model.width = camera.model.height = size;
  camera.model.fx = camera.model.fy = kFocal * size / kSize;
  camera.model.cx = camera.model.cy = size / 2.0;
  camera.cam_from_world =
      look_at(kMiddle + kDistance * Eigen::Vector3d(std::sin(a) * std::cos(e), std::sin(e),
                                                    std::cos(a) * std::cos(e)),
              kMiddle, Eigen::Vector3d::UnitY());
  return camera;
}

std::vector<RigCamera> bunny_grid(int side, double step, int size) {
  std::vector<RigCamera> cameras;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      cameras.push_back(bunny_camera(step * (column - 0.5 * (side - 1)),
                                     kMiddleElevation + step * (row - 0.5 * (side - 1)), size));
      cameras.back().serial = text(row, "-", column);
    }
  return cameras;
}

std::vector<RigCamera> bunny_cameras_anywhere(int count, std::uint64_t seed, int size) {
  Random random(seed);
  std::vector<RigCamera> cameras;
  for (int i = 0; i < count; ++i) {
    const double azimuth = random.uniform(-180, 180),
                 height = random.uniform(std::sin(kLowest * kRadian), std::sin(kHighest * kRadian));
    cameras.push_back(bunny_camera(azimuth, std::asin(height) / kRadian, size));
    cameras.back().serial = text("view", i);
  }
  return cameras;
}

double degrees_between(const RigCamera& a, const RigCamera& b) {
  const Eigen::Vector3d to_a = (a.cam_from_world.center() - kMiddle).normalized(),
                        to_b = (b.cam_from_world.center() - kMiddle).normalized();
  return std::acos(std::clamp(to_a.dot(to_b), -1.0, 1.0)) / kRadian;
}

std::vector<RigCamera> farthest_from(const std::vector<RigCamera>& from, int count, int size) {
  const std::vector<RigCamera> candidates = bunny_cameras_anywhere(kCandidates, 1, size);
  std::vector<std::pair<double, std::size_t>> by_angle;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    double nearest = 180;
    for (const RigCamera& camera : from) nearest = std::min(nearest, degrees_between(camera, candidates[i]));
    by_angle.emplace_back(-nearest, i);
  }
  std::sort(by_angle.begin(), by_angle.end());
  std::vector<RigCamera> chosen;
  for (const auto& [angle, i] : by_angle) {
    if (static_cast<int>(chosen.size()) == count) break;
    if (std::all_of(chosen.begin(), chosen.end(),
                    [&](const RigCamera& c) { return degrees_between(c, candidates[i]) >= kApart; }))
      chosen.push_back(candidates[i]);
  }
  return chosen;
}

TestScene painted_bunny(const Mesh& exact, const Mesh& proxy, const std::vector<RigCamera>& cameras,
                        const std::vector<RigCamera>& views) {
  std::vector<Photograph> taken(cameras.size() + views.size());
  const SolidColor paint = random_checker(kCell, kPaint);
  parallel_for(taken.size(), 0, [&](std::size_t i) {
    const RigCamera& c = i < cameras.size() ? cameras[i] : views[i - cameras.size()];
    taken[i] = photograph(exact, c.model, c.cam_from_world, kRays, paint);
  });
  TestScene scene;
  scene.rig.cameras = cameras;
  scene.photographs.mesh = proxy;
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (i >= cameras.size()) {
      scene.views.push_back({views[i - cameras.size()], taken[i].rgb, taken[i].alpha});
      continue;
    }
    FrameInfo info;
    info.camera = static_cast<int>(i);
    scene.photographs.images.frames.push_back(make_frame(info, taken[i].rgb));
    scene.photographs.mattes.push_back(make_matte(info, taken[i].alpha));
  }
  return scene;
}

}  // namespace floatstage::pipeline
