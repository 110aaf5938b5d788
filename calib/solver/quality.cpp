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
Measured tilt_of(const Scene& scene, int camera) {
  std::vector<Eigen::Vector3d> normals;
  for (const SceneView& v : scene.views) {
    if (v.camera != camera || v.board < 0 || !usable(scene, v)) continue;
    Eigen::Vector3d n = camera_from_target(scene, v).rotation * Eigen::Vector3d::UnitZ();
    if (n.z() < 0) n = -n;
    normals.push_back(n);
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& n : normals) mean += n;
  if (normals.size() < 2) return Measured::not_measured("fewer than two views show a board");
  mean.normalize();
  std::vector<double> angles;
  for (const Eigen::Vector3d& n : normals)
    angles.push_back(std::acos(std::clamp(n.dot(mean), -1.0, 1.0)) * kDegrees);
  const auto count = static_cast<long>(angles.size());
  return {percentile(std::move(angles), 0.95), count};
}

// Whether a camera's pose was solved for.
bool moves(const Eigen::VectorXd& variance) { return variance.segment<6>(kIntrinsics).maxCoeff() > 0; }

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

Measured rms_of(const std::vector<PointError>& errors, int camera) {
  double sum = 0;
  int count = 0;
  for (const PointError& e : errors)
    if (e.camera == camera && e.kept) {
      sum += e.error.squaredNorm();
      ++count;
    }
  return Measured::of(count > 0 ? std::sqrt(sum / count) : 0, count, "no point of this camera took part");
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
    const auto seen = static_cast<long>(lengths.size()), deep = static_cast<long>(depths.size());
    q.p95_px =
        Measured::of(seen > 0 ? percentile(std::move(lengths), 0.95) : 0, seen, "this camera saw no point");
    q.depth_ratio = Measured::of(deep > 0 ? percentile(depths, 0.95) / percentile(depths, 0.05) : 0, deep,
                                 "this camera saw no board");
    q.tilt_degrees = tilt_of(scene, index);
    q.covered = static_cast<double>(cells.size()) / (kColumns * kRows);
    const Eigen::Index row = kCameraParameters * static_cast<Eigen::Index>(c);
    const Eigen::VectorXd variance = covariance.diagonal().segment<kCameraParameters>(row);
    q.intrinsics_sigma = variance.head<kIntrinsics>().cwiseSqrt();
    const std::string why_still = camera.pose_fixed          ? "its pose was given and not solved for"
                                  : scene.reference == index ? "poses are relative to this camera"
                                                             : "it was placed by no view";
    q.rotation_sigma_degrees = Measured::of(std::sqrt(variance.segment<3>(kIntrinsics).sum()) * kDegrees,
                                            moves(variance) ? q.points : 0, why_still);
    // The camera's centre is -Rᵀt: it moves with the translation and with the rotation.
    Eigen::Matrix<double, 3, 6> center;
    const Eigen::Matrix3d turn = camera.cam_from_world.rotation.conjugate().toRotationMatrix();
    center << -turn * cross_matrix(camera.cam_from_world.translation), -turn;
    const Eigen::Matrix3d spread =
        center * covariance.block<6, 6>(row + kIntrinsics, row + kIntrinsics) * center.transpose();
    q.position_sigma_mm =
        Measured::of(1e3 * std::sqrt(spread.trace()), moves(variance) ? q.points : 0, why_still);
    const double offset_sigma = 1e3 * std::sqrt(variance[kIntrinsics + 6]);
    const std::string why_untimed = "time offsets were not solved for, or are relative to this camera";
    q.time_offset_ms = Measured::of(1e3 * camera.offset, offset_sigma > 0 ? q.points : 0, why_untimed);
    q.time_offset_sigma_ms = Measured::of(offset_sigma, offset_sigma > 0 ? q.points : 0, why_untimed);
    out.push_back(std::move(q));
  }
  return out;
}

}  // namespace floatstage::calib::solver
