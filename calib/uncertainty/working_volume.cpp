#include "calib/uncertainty/working_volume.h"

#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>

#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr int kSteps = 6;  // cells a side: 216 points, of which a hull has about half

std::string size_words(const WorkingVolume& v) {
  const Eigen::Vector3d s = v.high - v.low;
  return text(std::fixed, std::setprecision(2), s.x(), " x ", s.y(), " x ", s.z(), " m");
}

// Directions spread evenly over the sphere (a Fibonacci spiral).
std::vector<Eigen::Vector3d> directions(int count) {
  std::vector<Eigen::Vector3d> out;
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
    out.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return out;
}

std::vector<Eigen::Vector3d> grid(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<Eigen::Vector3d> out;
  const Eigen::Vector3d cell = (high - low) / kSteps;
  for (int z = 0; z < kSteps; ++z)
    for (int y = 0; y < kSteps; ++y)
      for (int x = 0; x < kSteps; ++x)
        out.push_back(low + cell.cwiseProduct(Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5)));
  return out;
}

}  // namespace

WorkingVolume box_volume(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  WorkingVolume v{grid(low, high), low, high, ""};
  v.how = "the given box, " + size_words(v);
  return v;
}

WorkingVolume hull_of_targets(const Calibration& c) {
  std::vector<Eigen::Vector3d> seen;
  for (const PointError& e : c.errors) {
    if (!e.kept) continue;
    const RigCamera& camera = c.rig.cameras[static_cast<std::size_t>(e.camera)];
    if (const std::optional<Eigen::Vector3d> ray = unproject(camera.model, e.pixel))
      seen.push_back(camera.cam_from_world.inverse() * Eigen::Vector3d(*ray * e.depth));
  }
  WorkingVolume v;
  if (seen.empty()) return v;
  v.low = v.high = seen[0];
  for (const Eigen::Vector3d& x : seen) {
    v.low = v.low.cwiseMin(x);
    v.high = v.high.cwiseMax(x);
  }
  const std::vector<Eigen::Vector3d> normals = directions(200);
  std::vector<double> reach(normals.size(), -std::numeric_limits<double>::infinity());
  for (const Eigen::Vector3d& x : seen)
    for (std::size_t i = 0; i < normals.size(); ++i) reach[i] = std::max(reach[i], normals[i].dot(x));
  for (const Eigen::Vector3d& x : grid(v.low, v.high)) {
    bool within = true;
    for (std::size_t i = 0; within && i < normals.size(); ++i) within = normals[i].dot(x) <= reach[i];
    if (within) v.points.push_back(x);
  }
  if (v.points.empty()) v.points.push_back(0.5 * (v.low + v.high));  // a sliver
  v.how = "the convex hull of all targets, " + size_words(v);
  return v;
}

Measured projection_sigma(const Calibration& c, const ProjectionUncertainty& uncertainty, int camera,
                          const WorkingVolume& volume) {
  const RigCamera& rc = c.rig.cameras[static_cast<std::size_t>(camera)];
  double sum = 0;
  long count = 0;
  for (const Eigen::Vector3d& x : volume.points) {
    const std::optional<Eigen::Vector2d> pixel = project(rc.model, rc.cam_from_world * x);
    if (!pixel || !inside(rc.model, *pixel)) continue;
    sum += std::pow(uncertainty.sigma_px(camera, x), 2);
    ++count;
  }
  return Measured::of(count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0, count,
                      "this camera sees nothing of the working volume");
}

}  // namespace floatstage::calib
