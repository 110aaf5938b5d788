#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "calib/calibrate.h"
#include "calib/solver/projection.h"
#include "calib/solver/scene.h"
#include "calib/uncertainty/working_volume.h"

namespace floatstage::calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Row = Eigen::Matrix<double, 2, kCovarianceRows>;

// How a camera's pixel of a world point changes with the camera's parameters.
bool derivative(const RigCamera& camera, const Eigen::Vector3d& in_world, Row& out) {
  const Eigen::Vector3d turned = camera.cam_from_world.rotation * in_world;
  const auto lens = static_cast<LensKind>(camera.model.lens.index());
  solver::Projected projected;
  if (!solver::project(solver::pack(camera.model), lens, turned + camera.cam_from_world.translation,
                       projected))
    return false;
  out << projected.by_intrinsics, -projected.by_point * solver::cross_matrix(turned), projected.by_point;
  return true;
}

// What is left of a step of all cameras' parameters when a common motion, which no picture shows, is taken
// out where it changes the projections of `volume` least. The identity where the world is given or there is
// no volume.
MatrixXd without_common_motion(const Rig& rig, int reference, const std::vector<Eigen::Vector3d>& volume) {
  const Index size = kCovarianceRows * static_cast<Index>(rig.cameras.size());
  MatrixXd keep = MatrixXd::Identity(size, size);
  if (reference < 0) return keep;  // the world is given: its motion would be seen
  // What a motion of the whole world (rotation vector, translation) does to the cameras' parameters.
  MatrixXd motion = MatrixXd::Zero(size, 6);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Eigen::Matrix3d r = rig.cameras[c].cam_from_world.rotation.toRotationMatrix();
    motion.block<3, 3>(kCovarianceRows * static_cast<Index>(c) + solver::kIntrinsics, 0) = r;
    motion.block<3, 3>(kCovarianceRows * static_cast<Index>(c) + solver::kIntrinsics + 3, 3) = r;
  }
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  MatrixXd right = MatrixXd::Zero(6, size);
  for (const Eigen::Vector3d& x : volume)
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      Row j;
      if (!derivative(rig.cameras[c], x, j)) continue;
      const Index at = kCovarianceRows * static_cast<Index>(c);
      const Eigen::Matrix<double, 2, 6> by_motion = j * motion.middleRows<kCovarianceRows>(at);
      normal += by_motion.transpose() * by_motion;
      right.middleCols<kCovarianceRows>(at) += by_motion.transpose() * j;
    }
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solved(normal);
  if (solved.info() == Eigen::Success && normal.diagonal().minCoeff() > 0)
    keep -= motion * solved.solve(right);
  return keep;
}

}  // namespace

ProjectionUncertainty::ProjectionUncertainty(const Calibration& calibration,
                                             const std::vector<Eigen::Vector3d>& volume)
    : rig_(calibration.rig), covariance_(calibration.covariance) {
  const MatrixXd keep = without_common_motion(rig_, calibration.reference, volume);
  covariance_ = keep * covariance_ * keep.transpose();
}

MatrixXd projection_metric(const Calibration& calibration, const WorkingVolume& volume) {
  const MatrixXd keep = without_common_motion(calibration.rig, calibration.reference, volume.points);
  MatrixXd metric = MatrixXd::Zero(keep.rows(), keep.cols());
  for (std::size_t c = 0; c < calibration.rig.cameras.size(); ++c) {
    const RigCamera& camera = calibration.rig.cameras[c];
    Eigen::Matrix<double, kCovarianceRows, kCovarianceRows> own =
        Eigen::Matrix<double, kCovarianceRows, kCovarianceRows>::Zero();
    for (const Eigen::Vector3d& x : volume.points) {
      const auto pixel = project(camera.model, camera.cam_from_world * x);
      if (Row j; pixel && inside(camera.model, *pixel) && derivative(camera, x, j))
        own += 0.5 * j.transpose() * j;
    }
    const Index at = kCovarianceRows * static_cast<Index>(c);
    const MatrixXd here = keep.middleRows<kCovarianceRows>(at);
    const MatrixXd of_camera = here.transpose() * own * here;
    const double sum = of_camera.cwiseProduct(calibration.covariance).sum();  // the trace of their product
    if (sum > 0 && std::isfinite(sum)) metric += of_camera / sum;
  }
  return metric;
}

double ProjectionUncertainty::sigma_px(int camera, const Eigen::Vector3d& in_world) const {
  Row j;
  if (!derivative(rig_.cameras[static_cast<std::size_t>(camera)], in_world, j))
    return std::numeric_limits<double>::infinity();
  const Index at = kCovarianceRows * static_cast<Index>(camera);
  return std::sqrt(std::max(
      0.0, 0.5 * (j * covariance_.block<kCovarianceRows, kCovarianceRows>(at, at) * j.transpose()).trace()));
}

}  // namespace floatstage::calib
