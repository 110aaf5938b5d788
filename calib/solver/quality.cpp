#include "calib/solver/quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "calib/solver/start.h"
#include "core/statistics.h"

namespace floatstage::calib::solver {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The largest angle between a camera's board views and their mean direction; opposite faces count as one.
double tilt_of(const Scene& scene, int camera) {
  std::vector<Eigen::Vector3d> normals;
  for (const SceneView& v : scene.views) {
    if (v.camera != camera || v.board < 0 || !usable(scene, v)) continue;
    Eigen::Vector3d n = camera_from_target(scene, v).rotation * Eigen::Vector3d::UnitZ();
    if (n.z() < 0) n = -n;
    normals.push_back(n);
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& n : normals) mean += n;
  if (mean.norm() == 0) return 0;
  mean.normalize();
  std::vector<double> angles;
  for (const Eigen::Vector3d& n : normals)
    angles.push_back(std::acos(std::clamp(n.dot(mean), -1.0, 1.0)) * kDegrees);
  return percentile(std::move(angles), 0.95);
}

}  // namespace

std::vector<PointError> point_errors(const Scene& scene, const Observations& o) {
  std::vector<PointError> out;
  for (const SceneView& v : scene.views) {
    if (!usable(scene, v)) continue;
    const TargetView& source = o.views[at(v.source)];
    const Target& target = scene.targets[at(source.target)];
    const SceneCamera& camera = scene.cameras[at(v.camera)];
    const std::vector<Eigen::Vector2d> errors = errors_of(scene, v);
    const Rigid3 from_target = v.board >= 0 ? camera_from_target(scene, v) : Rigid3{};
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const ScenePoint& p = v.points[i];
      const auto index = at(v.board >= 0 ? p.index : scene.markers[at(v.markers)].indices[at(p.index)]);
      const Eigen::Vector3d x =
          v.board >= 0 ? from_target * target.points[index].position
                       : camera.cam_from_world * scene.markers[at(v.markers)].positions[at(p.index)];
      out.push_back({v.camera, source.frame, target.points[index].id, source.target, p.pixel, errors[i],
                     x.z(), p.kept});
    }
  }
  return out;
}

double rms_of(const std::vector<PointError>& errors, int camera) {
  double sum = 0;
  int count = 0;
  for (const PointError& e : errors)
    if (e.camera == camera && e.kept) {
      sum += e.error.squaredNorm();
      ++count;
    }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

std::vector<CameraQuality> camera_qualities(const Scene& scene, const std::vector<PointError>& errors,
                                            const Eigen::MatrixXd& covariance) {
  std::vector<CameraQuality> out;
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    const SceneCamera& camera = scene.cameras[c];
    const auto index = static_cast<int>(c);
    CameraQuality q;
    q.serial = camera.serial;
    std::vector<double> lengths, depths;
    std::set<std::pair<int, int>> frames;
    constexpr int kColumns = 8, kRows = 6;
    std::set<int> cells;
    for (const PointError& e : errors) {
      if (e.camera != index) continue;
      frames.insert({e.target, e.frame});
      ++(e.kept ? q.points : q.outliers);
      if (std::isfinite(e.error.norm())) lengths.push_back(e.error.norm());
      if (!e.kept) continue;
      if (scene.targets[at(e.target)].kind == TargetKind::Board) depths.push_back(e.depth);
      const int column = static_cast<int>(e.pixel.x() / camera.width * kColumns),
                row = static_cast<int>(e.pixel.y() / camera.height * kRows);
      if (column >= 0 && column < kColumns && row >= 0 && row < kRows) cells.insert(row * kColumns + column);
    }
    q.views = static_cast<int>(frames.size());
    q.rms_px = rms_of(errors, index);
    q.p95_px = lengths.empty() ? 0 : percentile(std::move(lengths), 0.95);
    if (!depths.empty()) q.depth_ratio = percentile(depths, 0.95) / percentile(depths, 0.05);
    q.tilt_degrees = tilt_of(scene, index);
    q.covered = static_cast<double>(cells.size()) / (kColumns * kRows);
    const Eigen::Index row = kCameraParameters * static_cast<Eigen::Index>(c);
    const Eigen::VectorXd variance = covariance.diagonal().segment<kCameraParameters>(row);
    q.intrinsics_sigma = variance.head<kIntrinsics>().cwiseSqrt();
    q.rotation_sigma_degrees = std::sqrt(variance.segment<3>(kIntrinsics).sum()) * kDegrees;
    // The camera's centre is -Rᵀt: it moves with the translation and with the rotation.
    Eigen::Matrix<double, 3, 6> center;
    const Eigen::Matrix3d turn = camera.cam_from_world.rotation.conjugate().toRotationMatrix();
    center << -turn * cross_matrix(camera.cam_from_world.translation), -turn;
    q.position_sigma_mm =
        1e3 *
        std::sqrt((center * covariance.block<6, 6>(row + kIntrinsics, row + kIntrinsics) * center.transpose())
                      .trace());
    q.time_offset_ms = 1e3 * camera.offset;
    q.time_offset_sigma_ms = 1e3 * std::sqrt(variance[kIntrinsics + 6]);
    out.push_back(std::move(q));
  }
  return out;
}

}  // namespace floatstage::calib::solver
