// The axis and the circle of cameras that stand around something. The axis comes from the pictures: their
// level sides span the plane across it, and its direction is the eigenvector of the least eigenvalue of
// sum r r' (as COLMAP's model_orientation_aligner and photo stitchers straighten horizons: M. Brown, D. Lowe,
// Automatic Panoramic Image Stitching, IJCV 2007, section 5; here each picture may also lie on its side).
// The circle is I. Kasa's algebraic fit (1976), reweighted to the least sum of distances.
// docs/adr/0238-orbits-follow-the-ring.md

#include "pipeline/ring.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

namespace floatstage::pipeline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Solver = Eigen::SelfAdjointEigenSolver<Matrix3d>;

struct Axes {
  Vector3d x, y, z;  // right, down, forward, in the world
};

std::vector<Axes> axes_of(const Rig& rig) {
  std::vector<Axes> out;
  for (const RigCamera& c : rig.cameras) {
    const Matrix3d world_from_cam = c.cam_from_world.rotation.conjugate().toRotationMatrix();
    out.push_back({world_from_cam.col(0), world_from_cam.col(1), world_from_cam.col(2)});
  }
  return out;
}

// The direction with the least variance, that variance and the next one.
struct Least {
  Vector3d direction;
  double variance, next;
};
Least least(const Matrix3d& sum, std::size_t count) {
  const Solver solver(sum / static_cast<double>(count));
  return {solver.eigenvectors().col(0), std::max(0.0, solver.eigenvalues()(0)), solver.eigenvalues()(1)};
}

const Vector3d& level_side(const Axes& camera, const Vector3d& axis) {
  return std::abs(camera.x.dot(axis)) <= std::abs(camera.y.dot(axis)) ? camera.x : camera.y;
}

// From a first guess of the axis: which side of each picture is level, which axis that makes, and so on.
Least settled(const std::vector<Axes>& cameras, Vector3d axis) {
  Least found{axis, 0, 0};
  for (int round = 0; round < 8; ++round) {
    Matrix3d sum = Matrix3d::Zero();
    for (const Axes& c : cameras) {
      const Vector3d& side = level_side(c, found.direction);
      sum += side * side.transpose();
    }
    found = least(sum, cameras.size());
  }
  return found;
}

Least plane_of_centers(const Rig& rig) {
  Vector3d mean = Vector3d::Zero();
  for (const RigCamera& c : rig.cameras) mean += c.cam_from_world.center();
  mean /= static_cast<double>(rig.cameras.size());
  Matrix3d sum = Matrix3d::Zero();
  for (const RigCamera& c : rig.cameras) {
    const Vector3d d = c.cam_from_world.center() - mean;
    sum += d * d.transpose();
  }
  return least(sum, rig.cameras.size());
}

// An axis is told when what stands along it is clearly less than what stands across.
bool is_told(const Least& l) { return 4 * l.variance < l.next; }

// Upright pictures say it; such as lie on their side only by looking down, and level ones not at all.
Vector3d upwards(const std::vector<Axes>& cameras, const Vector3d& axis) {
  double upper_edges = 0, looking_down = 0, right_edges = 0;
  for (const Axes& c : cameras) {
    if (&level_side(c, axis) == &c.x) upper_edges -= c.y.dot(axis);
    looking_down -= c.z.dot(axis);
    right_edges += c.x.dot(axis);
  }
  const double least_sure = 0.01 * static_cast<double>(cameras.size());
  for (const double vote : {upper_edges, looking_down, right_edges})
    if (std::abs(vote) > least_sure) return vote > 0 ? axis : Vector3d(-axis);
  return axis;
}

}  // namespace

UpAxis up_axis(const Rig& rig) {
  const std::vector<Axes> cameras = axes_of(rig);
  Matrix3d right = Matrix3d::Zero(), down = Matrix3d::Zero();
  double facing = 0;  // how much the cameras look along the normal of the plane they stand in
  const Least plane = plane_of_centers(rig);
  for (const Axes& c : cameras) {
    right += c.x * c.x.transpose();
    down += c.y * c.y.transpose();
    facing += std::abs(c.z.dot(plane.direction)) / static_cast<double>(cameras.size());
  }
  Least best{Vector3d::UnitZ(), 0, 0};
  for (const Vector3d& guess :
       {least(right, cameras.size()).direction, least(down, cameras.size()).direction, plane.direction}) {
    const Least found = settled(cameras, guess);
    if (found.next - found.variance > best.next - best.variance) best = found;
  }
  // Cameras that all face one way to within two degrees have level sides that are all but parallel.
  constexpr double kFacesOneWay = 1e-3;
  if (best.next > kFacesOneWay && is_told(best)) {
    const double roll = std::asin(std::min(1.0, std::sqrt(best.variance)));
    const Vector3d up = upwards(cameras, best.direction);
    const bool is_z = std::acos(std::min(1.0, up.z())) <= roll;
    return {is_z ? Vector3d::UnitZ() : up, UpAxis::From::Pictures, roll};
  }
  const bool around = facing < std::sqrt(0.5);
  if (rig.cameras.size() > 3 && is_told(plane) && around)
    return {upwards(cameras, plane.direction), UpAxis::From::Centers, 0};
  return {mean_up(rig), UpAxis::From::MeanUp, 0};
}

Ring fit_ring(const Rig& rig, const Vector3d& axis) {
  const Vector3d east = axis.unitOrthogonal(), north = axis.cross(east);
  const std::size_t n = rig.cameras.size();
  std::vector<Eigen::Vector2d> at;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double height = 0;
  for (const RigCamera& c : rig.cameras) {
    const Vector3d p = c.cam_from_world.center();
    at.emplace_back(p.dot(east), p.dot(north));
    mean += at.back() / static_cast<double>(n);
    height += p.dot(axis) / static_cast<double>(n);
  }
  Eigen::Vector2d center = mean;
  double radius = 0;
  std::vector<double> weights(n, 1);
  Matrix3d normal;
  for (int round = 0; round < 30; ++round) {
    Matrix3d a = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d p = at[i] - mean;
      const Vector3d row(2 * p.x(), 2 * p.y(), 1);
      a += weights[i] * row * row.transpose();
      b += weights[i] * row * p.squaredNorm();
    }
    const Eigen::FullPivLU<Matrix3d> lu(a);
    if (n < 3 || !lu.isInvertible()) break;
    const Vector3d solved = lu.solve(b);
    center = mean + solved.head<2>();
    radius = std::sqrt(std::max(0.0, solved.z() + solved.head<2>().squaredNorm()));
    for (std::size_t i = 0; i < n; ++i)
      weights[i] = 1 / std::max(std::abs((at[i] - center).norm() - radius), 1e-4 * radius);
  }
  double error = std::numeric_limits<double>::infinity(), squares = 0;
  normal.setZero();
  for (const Eigen::Vector2d& p : at) {
    const double off = (p - center).norm();
    const Vector3d row((p - center).x() / off, (p - center).y() / off, 1);
    normal += row * row.transpose();
    squares += (off - radius) * (off - radius);
  }
  const Eigen::FullPivLU<Matrix3d> lu(normal);
  if (n > 3 && radius > 0 && lu.isInvertible())
    error = std::sqrt(squares / static_cast<double>(n - 3) * lu.inverse().topLeftCorner<2, 2>().trace());
  return {axis, east * center.x() + north * center.y() + axis * height, radius, error};
}

}  // namespace floatstage::pipeline
