#include "pipeline/reproduce/ball_before_wall.h"

#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/synthetic/mesh_photograph.h"
#include "core/text.h"
#include "pipeline/metrics/metrics.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;

constexpr double kRadian = std::numbers::pi / 180;
constexpr double kBall = 0.13, kWall = 0.312, kProxyWall = 0.332, kDistance = 1.3;  // metres
constexpr int kFineRings = 48, kCoarseRings = 8;
constexpr double kCoarseBall = 1.02, kAroundBall = 1.08;  // of the true radius
constexpr float kCell = 0.025F;                           // metres
constexpr int kRays = 3, kAbout = 8;                      // a pixel along each side; px
constexpr double kAngles[] = {-24, -8, 8, 24};            // degrees

constexpr int kMostViews = 3;
constexpr double kViews[kMostViews] = {0, -16, 16};  // degrees: in the middle between two cameras

void add_ball(double radius, int rings, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const int around = 2 * rings;
  for (int r = 0; r <= rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * a / around;
      mesh.positions.push_back((radius * Vector3d(std::sin(theta) * std::cos(phi),
                                                  std::sin(theta) * std::sin(phi), std::cos(theta)))
                                   .cast<float>());
    }
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      auto at = [&](int row, int column) {
        return first + static_cast<std::uint32_t>(row * around + column % around);
      };
      const std::uint32_t nw = at(r, a), ne = at(r, a + 1), sw = at(r + 1, a), se = at(r + 1, a + 1);
      if (r > 0) mesh.triangles.insert(mesh.triangles.end(), {nw, sw, ne});
      if (r + 1 < rings) mesh.triangles.insert(mesh.triangles.end(), {ne, sw, se});
    }
}

// Across y, seen from where y is less.
void add_wall(double y, Mesh& mesh) {
  constexpr float kWide = 1, kHigh = 0.8F;  // metres
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& [x, z] : {std::pair(-kWide, kHigh), std::pair(-kWide, -kHigh), std::pair(kWide, -kHigh),
                             std::pair(kWide, kHigh)})
    mesh.positions.emplace_back(x, static_cast<float>(y), z);
  mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
}

RigCamera camera_at(double degrees, const BallOptions& o) {
  RigCamera camera;
  camera.model.width = o.width;
  camera.model.height = o.height;
  camera.model.fx = camera.model.fy = 2.2 * o.width;
  camera.model.cx = o.width / 2.0;
  camera.model.cy = o.height / 2.0;
  const double a = degrees * kRadian;
  camera.cam_from_world =
      look_at(kDistance * Vector3d(std::sin(a), -std::cos(a), 0.12), Vector3d::Zero(), Vector3d::UnitZ());
  return camera;
}

Image brighter(Image rgb, double gain) {
  for (std::uint8_t& v : rgb.pixels) v = static_cast<std::uint8_t>(std::lround(std::min(255.0, v * gain)));
  return rgb;
}

// Whether a ball stands between a point and an eye.
bool hidden(const Vector3d& point, const Vector3d& eye, double radius = kBall) {
  const Vector3d way = eye - point;
  const double t = -point.dot(way) / way.squaredNorm();
  return t > 0 && t < 1 && (point + t * way).norm() < radius;
}

}  // namespace

TestScene ball_before_wall(const BallOptions& options) {
  Mesh truth;
  add_ball(kBall, kFineRings, truth);
  add_wall(kWall, truth);
  TestScene scene;
  add_ball(kCoarseBall * kBall, kCoarseRings, scene.photographs.mesh);
  add_wall(kProxyWall, scene.photographs.mesh);
  std::vector<RigCamera> cameras;
  for (const double angle : kAngles) cameras.push_back(camera_at(angle, options));
  const auto count = cameras.size();
  for (int v = 0; v < options.views; ++v) cameras.push_back(camera_at(kViews[v % kMostViews], options));
  std::vector<Image> taken(cameras.size());
  const SolidColor paint = random_checker(kCell, 58);
  parallel_for(taken.size(), 0, [&](std::size_t i) {
    taken[i] = photograph(truth, cameras[i].model, cameras[i].cam_from_world, kRays, paint).rgb;
  });
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (i >= count) {
      scene.views.push_back({cameras[i], std::move(taken[i]), {}});
      continue;
    }
    const double side = i % 2 == 0 ? -1 : 1;
    FrameInfo info;
    info.camera = static_cast<int>(i);
    scene.photographs.images.frames.push_back(make_frame(info, brighter(taken[i], 1 + options.gain * side)));
    scene.photographs.mattes.emplace_back();
    cameras[i].serial = text("cam", i);
    cameras[i].model.cx += options.off * side;
    cameras[i].model.cy -= options.off * side;
    scene.rig.cameras.push_back(cameras[i]);
  }
  return scene;
}

Image about_occlusions(const TestScene& scene, const RigCamera& view) {
  const CameraModel& m = view.model;
  const Vector3d eye = view.cam_from_world.center();
  Image all_see(m.width, m.height, 1, 255), wall(m.width, m.height, 1);
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const Vector3d way = view.cam_from_world.rotation.conjugate() * *unproject(m, {x + 0.5, y + 0.5});
      const Vector3d on_wall = eye + way * ((kWall - eye.y()) / way.y());
      if (hidden(on_wall, eye, kAroundBall * kBall)) continue;  // what the proxy's wrong outline spoils
      *wall.at(x, y) = 255;
      for (const RigCamera& camera : scene.rig.cameras)
        if (hidden(on_wall, camera.cam_from_world.center())) *all_see.at(x, y) = 0;
    }
  Image about = erode_mask(all_see, kAbout);
  for (std::size_t i = 0; i < about.pixels.size(); ++i)
    about.pixels[i] = wall.pixels[i] >= 128 && about.pixels[i] < 128 ? 255 : 0;
  return about;
}

}  // namespace floatstage::pipeline
