// Method:  the solved scene and its covariance moved into the world that was asked for
// Paper:   S. Umeyama's alignment (1991) without scale, weighted by one over its distances
// Differs: what has moved since yesterday is weighted down, so
//          that the rest stays where it was
// ADR:     none; docs/algorithms/calibration.md

#include "calib/solver/gauge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "calib/solver/bundle.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Rig rig_of(const Scene& scene) {
  Rig rig;
  for (const SceneCamera& c : scene.cameras)
    rig.cameras.push_back({c.serial, unpack(c.intrinsics, c.lens, c.width, c.height), c.cam_from_world, {}});
  return rig;
}

// The rotation whose columns are x, y and z of the new world in the old one.
Matrix3d axes(const Vector3d& along_x, const Vector3d& up) {
  Matrix3d m;
  m.col(2) = up.normalized();
  m.col(0) = (along_x - along_x.dot(m.col(2)) * m.col(2)).normalized();
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

Rigid3 to_axes(const Vector3d& origin, const Matrix3d& columns) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond(Matrix3d(columns.transpose())).normalized();
  return {turn, turn * -origin};
}

Result<Rigid3> from_floor(const Scene& scene, const FloorBoard& floor) {
  for (const SceneView& v : scene.views) {
    if (v.board < 0 || !usable(scene, v)) continue;
    const SceneBoard& b = scene.boards[at(v.board)];
    if (b.target != floor.target || (b.frame != floor.frame && !scene.targets[at(b.target)].is_static))
      continue;
    Vector3d up = b.world_from_target.rotation * Vector3d::UnitZ();
    const Vector3d to_camera =
        scene.cameras[at(v.camera)].cam_from_world.center() - b.world_from_target.translation;
    if (up.dot(to_camera) < 0) up = -up;
    const Vector3d along = b.world_from_target.rotation * Vector3d::UnitX();
    return to_axes(b.world_from_target.translation - floor.height * up, axes(along, up));
  }
  return fail(ErrorCode::BadData,
              text("the floor is to be set by target '", scene.targets[at(floor.target)].name, "' in frame ",
                   floor.frame, ", which no camera saw well; choose a frame in which it lies in view"));
}

// Upright and centred as far as cameras alone can tell.
Rigid3 from_cameras(const Scene& scene) {
  const Rig rig = rig_of(scene);
  const Vector3d up = mean_up(rig), focus = focus_point(rig);
  Vector3d along = rig.cameras.front().cam_from_world.rotation.conjugate() * Vector3d::UnitX();
  if (along.cross(up).norm() < 1e-3) along = up.unitOrthogonal();
  return to_axes(focus, axes(along, up));
}

// The motion that takes the solved cameras nearest to where they started: most of a rig has not moved, so
// what has moved is weighted down.
Rigid3 to_start(const Scene& scene, const Observations& o) {
  std::vector<std::pair<Rigid3, Rigid3>> pairs;  // world_from_cam, before and now
  for (std::size_t c = 0; c < o.cameras.size(); ++c)
    if (o.cameras[c].pose == Prior::Start)
      pairs.emplace_back(o.cameras[c].cam_from_world.inverse(), scene.cameras[c].cam_from_world.inverse());
  Rigid3 motion;
  double depth = 1;  // metres ahead of a camera: what it looks at should stay as its centre does
  std::vector<double> weights(pairs.size(), 1);
  for (int round = 0; round < 20; ++round) {
    std::vector<Vector3d> from, to;
    std::vector<double> w;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(depth, 0, depth), Vector3d(-depth, 0, depth),
                                Vector3d(0, depth, depth)}) {
        from.push_back(pairs[i].second * p);
        to.push_back(pairs[i].first * p);
        w.push_back(weights[i]);
      }
    double total = 0;
    Vector3d mean_from = Vector3d::Zero(), mean_to = Vector3d::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) {
      total += w[i];
      mean_from += w[i] * from[i];
      mean_to += w[i] * to[i];
    }
    mean_from /= total;
    mean_to /= total;
    Matrix3d cross = Matrix3d::Zero();
    for (std::size_t i = 0; i < from.size(); ++i)
      cross += w[i] * (to[i] - mean_to) * (from[i] - mean_from).transpose();
    const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Matrix3d turn = svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    motion = {Eigen::Quaterniond(turn).normalized(), mean_to - turn * mean_from};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      double off = 0;
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) off += (motion * from[k] - to[k]).norm();
      weights[i] = 1 / std::max(off, 1e-4);
    }
  }
  return motion;
}

void move_world(Scene& scene, const Rigid3& new_from_old, Eigen::MatrixXd& covariance) {
  const Rigid3 old_from_new = new_from_old.inverse();
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    SceneCamera& camera = scene.cameras[c];
    const Vector3d before = camera.cam_from_world.translation;
    camera.cam_from_world = camera.cam_from_world * old_from_new;
    camera.cam_from_world.rotation.normalize();
    // A turn from the left now also carries along what the translation gained.
    Eigen::Matrix<double, 6, 6> change = Eigen::Matrix<double, 6, 6>::Identity();
    change.bottomLeftCorner<3, 3>() = -cross_matrix(camera.cam_from_world.translation - before);
    const Eigen::Index at_pose = kCameraParameters * static_cast<Eigen::Index>(c) + kIntrinsics;
    covariance.middleRows<6>(at_pose) = (change * covariance.middleRows<6>(at_pose)).eval();
    covariance.middleCols<6>(at_pose) = (covariance.middleCols<6>(at_pose) * change.transpose()).eval();
  }
  for (SceneBoard& b : scene.boards) {
    b.world_from_target = new_from_old * b.world_from_target;
    b.spin = new_from_old.rotation * b.spin;
    b.velocity = new_from_old.rotation * b.velocity;
    b.acceleration = new_from_old.rotation * b.acceleration;
  }
  for (SceneMarkers& m : scene.markers) {
    for (Vector3d& p : m.positions) p = new_from_old * p;
    for (Vector3d& v : m.velocities) v = new_from_old.rotation * v;
  }
}

}  // namespace

Result<void> set_gauge(Scene& scene, const Observations& o, Eigen::MatrixXd& covariance,
                       std::vector<std::string>& remarks) {
  Rigid3 new_from_old;
  if (const auto* floor = std::get_if<FloorBoard>(&o.gauge)) {
    const Result<Rigid3> found = from_floor(scene, *floor);
    if (!found) return forward(found);
    new_from_old = *found;
  } else if (const auto* hand = std::get_if<HandSet>(&o.gauge)) {
    new_from_old = hand->cam_from_world.inverse() * scene.cameras[at(hand->camera)].cam_from_world;
  } else if (scene.reference < 0) {
    return {};  // fixed poses or surveyed markers are the world
  } else if (std::any_of(o.cameras.begin(), o.cameras.end(),
                         [](const CalibrationCamera& c) { return c.pose == Prior::Start; })) {
    new_from_old = to_start(scene, o);
  } else {
    new_from_old = from_cameras(scene);
    remarks.push_back(
        "the world is set by the cameras alone: z is their mean up, and where the floor is remains unknown; "
        "lay the board on the "
        "floor in one frame and name it, or set a camera's pose by hand");
  }
  move_world(scene, new_from_old, covariance);
  return {};
}

}  // namespace floatstage::calib::solver
