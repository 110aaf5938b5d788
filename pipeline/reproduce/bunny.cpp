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
constexpr double kDistance = 0.45;            // metres
constexpr double kFocal = 1150, kSize = 512;  // px
constexpr double kMiddleElevation = 15;       // degrees
constexpr float kCell = 0.006F;               // metres
constexpr std::uint64_t kPaint = 7;
constexpr int kRays = 3;  // a pixel, along each side
constexpr int kCandidates = 4000;
constexpr std::uint64_t kCandidatesSeed = 52;

const Eigen::Vector3d kMiddle(-0.017, 0.11, 0);  // the scan's world is y up

Eigen::Vector3d direction_of(const RigCamera& camera) {
  return (camera.cam_from_world.center() - kMiddle).normalized();
}

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

std::vector<RigCamera> bunny_cameras(int count, const BunnySky& sky, std::uint64_t seed, int size) {
  Random random(seed);
  std::vector<RigCamera> cameras;
  for (int i = 0; i < count; ++i) {
    const double azimuth = random.uniform(-sky.azimuth, sky.azimuth),
                 height = random.uniform(std::sin(sky.lowest * kRadian), std::sin(sky.highest * kRadian));
    cameras.push_back(bunny_camera(azimuth, std::asin(height) / kRadian, size));
    cameras.back().serial = text("view", i);
  }
  return cameras;
}

double degrees_between(const RigCamera& a, const RigCamera& b) {
  return std::acos(std::clamp(direction_of(a).dot(direction_of(b)), -1.0, 1.0)) / kRadian;
}

std::vector<RigCamera> bunny_views_between(const std::vector<RigCamera>& cameras, const BunnySky& sky,
                                           int count, double apart, BetweenOrder order, int size) {
  std::vector<std::pair<double, RigCamera>> between;
  for (const RigCamera& view : bunny_cameras(kCandidates, sky, kCandidatesSeed, size)) {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < cameras.size(); ++i) near.emplace_back(degrees_between(cameras[i], view), i);
    if (near.size() < 3) break;
    std::partial_sort(near.begin(), near.begin() + 3, near.end());
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k)
      corners.col(k) = direction_of(cameras[near[static_cast<std::size_t>(k)].second]);
    const Eigen::Vector3d shares = corners.fullPivLu().solve(direction_of(view));
    if (shares.minCoeff() >= 0) between.emplace_back(near.front().first, view);
  }
  if (order == BetweenOrder::FarthestFirst)
    std::stable_sort(between.begin(), between.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<RigCamera> chosen;
  for (const auto& [degrees, view] : between) {
    if (static_cast<int>(chosen.size()) == count) break;
    if (std::all_of(chosen.begin(), chosen.end(),
                    [&](const RigCamera& c) { return degrees_between(c, view) >= apart; }))
      chosen.push_back(view);
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
