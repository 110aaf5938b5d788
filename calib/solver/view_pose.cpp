// Method:  a target's pose in one picture from a homography or a projection matrix, then refined
// Paper:   Z. Zhang, "A flexible new technique for camera calibration", 2000, section 3.1; Hartley's
//          normalisation, 1997
// Differs: weighted again by its residuals, and refined from both tilts that a flat board can have
// ADR:     none; docs/algorithms/calibration.md

#include "calib/solver/view_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "calib/solver/scene.h"
#include "core/statistics.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Two equations a point in 9 or 12 unknowns. Of sizes that are known when they are made: for each that g++
// knows itself it takes many seconds.
using Equations = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 12>;
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 12, 1>;

Unknowns smallest_eigenvector(const Normal& normal) {
  return Eigen::SelfAdjointEigenSolver<Normal>(normal).eigenvectors().col(0);
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The plane through a target's points: an orthonormal frame with z across it, and whether they lie in it.
struct Plane {
  Vector3d center;
  Matrix3d axes;  // columns
  bool flat = false, thin = false;
};

Plane plane_of(const std::vector<Correspondence>& points) {
  Plane p;
  p.center.setZero();
  for (const Correspondence& c : points) p.center += c.position / static_cast<double>(points.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Correspondence& c : points)
    spread += (c.position - p.center) * (c.position - p.center).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(spread);  // ascending
  p.axes.col(0) = eigen.eigenvectors().col(2);
  p.axes.col(1) = eigen.eigenvectors().col(1);
  p.axes.col(2) = p.axes.col(0).cross(p.axes.col(1));
  p.thin = !(eigen.eigenvalues()[1] > 1e-4 * eigen.eigenvalues()[2]);  // along a line
  p.flat = eigen.eigenvalues()[0] < 1e-6 * eigen.eigenvalues()[2];
  return p;
}

// x scaled and shifted to unit size around 0 (Hartley): y = scale * (x - shift).
struct Normalizer {
  Vector2d shift = Vector2d::Zero();
  double scale = 1;
  explicit Normalizer(const std::vector<Vector2d>& points) {
    for (const Vector2d& p : points) shift += p / static_cast<double>(points.size());
    double spread = 0;
    for (const Vector2d& p : points) spread += (p - shift).norm() / static_cast<double>(points.size());
    scale = spread > 0 ? std::sqrt(2.0) / spread : 1;
  }
  Matrix3d matrix() const {
    Matrix3d m;
    m << scale, 0, -scale * shift.x(), 0, scale, -scale * shift.y(), 0, 0, 1;
    return m;
  }
};

std::optional<Vector2d> apply(const Matrix3d& h, const Vector2d& p) {
  const Vector3d q = h * p.homogeneous();
  if (std::abs(q.z()) < 1e-12) return std::nullopt;
  return Vector2d(q.head<2>() / q.z());
}

// Direct linear transform, weighted again by its own residuals until wrong points count for nothing.
std::optional<Matrix3d> fit_homography(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
  if (from.size() < 4) return std::nullopt;
  const Normalizer a(from), b(to);
  std::vector<double> weights(from.size(), 1);
  Matrix3d h;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    Normal normal = Normal::Zero(9, 9);
    Equations rows(2, 9);
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Vector3d x = ((from[i] - a.shift) * a.scale).homogeneous();
      const Vector2d y = (to[i] - b.shift) * b.scale;
      rows << x.transpose(), 0, 0, 0, -y.x() * x.transpose(), 0, 0, 0, x.transpose(), -y.y() * x.transpose();
      normal += weights[i] * rows.transpose() * rows;
    }
    const Unknowns v = smallest_eigenvector(normal);
    Matrix3d n;
    n << v.head<3>().transpose(), v.segment<3>(3).transpose(), v.tail<3>().transpose();
    h = b.matrix().inverse() * n * a.matrix();
    std::vector<double> errors;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const std::optional<Vector2d> p = apply(h, from[i]);
      errors.push_back(p ? (*p - to[i]).norm() * b.scale : 1e3);
    }
    const double scale = std::max(3 * median(errors), 1e-6);
    for (std::size_t i = 0; i < from.size(); ++i)
      weights[i] = 1 / std::pow(1 + std::pow(errors[i] / scale, 2), 2);
  }
  if (!h.allFinite()) return std::nullopt;
  return h;
}

Matrix3d nearest_rotation(const Matrix3d& m) {
  const Eigen::JacobiSVD<Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d r = svd.matrixU() * svd.matrixV().transpose();
  if (r.determinant() < 0) r = svd.matrixU() * Vector3d(1, 1, -1).asDiagonal() * svd.matrixV().transpose();
  return r;
}

std::optional<Rigid3> pose_of_flat(const Plane& plane, const std::vector<Vector3d>& positions,
                                   const std::vector<Vector2d>& rays) {
  std::vector<Vector2d> flat;
  for (const Vector3d& p : positions) flat.push_back((plane.axes.transpose() * (p - plane.center)).head<2>());
  const std::optional<Matrix3d> h = fit_homography(flat, rays);
  if (!h) return std::nullopt;
  const double scale = 2 / (h->col(0).norm() + h->col(1).norm());
  if (!std::isfinite(scale)) return std::nullopt;
  Matrix3d m = *h * (h->coeff(2, 2) < 0 ? -scale : scale);  // the board's centre is in front of the camera
  const Vector3d t = m.col(2);
  m.col(2) = m.col(0).cross(m.col(1));
  const Matrix3d rotation = nearest_rotation(m) * plane.axes.transpose();
  return Rigid3{Eigen::Quaterniond(rotation).normalized(), t - rotation * plane.center};
}

std::optional<Rigid3> pose_of_solid(const Plane& plane, const std::vector<Vector3d>& positions,
                                    const std::vector<Vector2d>& rays) {
  if (positions.size() < 6) return std::nullopt;
  Normal normal = Normal::Zero(12, 12);
  Equations rows = Equations::Zero(2, 12);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector4d x = (positions[i] - plane.center).homogeneous();
    rows.block<1, 4>(0, 0) = x.transpose();
    rows.block<1, 4>(1, 4) = x.transpose();
    rows.rightCols<4>() = -rays[i] * x.transpose();
    normal += rows.transpose() * rows;
  }
  const Unknowns v = smallest_eigenvector(normal);
  Eigen::Matrix<double, 3, 4> p;
  p << v.head<4>().transpose(), v.segment<4>(4).transpose(), v.tail<4>().transpose();
  if (p(2, 3) < 0) p = -p;
  const double scale = 3 / p.leftCols<3>().colwise().norm().sum();
  if (!std::isfinite(scale)) return std::nullopt;
  const Matrix3d rotation = nearest_rotation(p.leftCols<3>() * scale);
  return Rigid3{Eigen::Quaterniond(rotation).normalized(), p.col(3) * scale - rotation * plane.center};
}

double median_error(const Intrinsics& in, LensKind lens, const std::vector<Correspondence>& points,
                    const Rigid3& pose) {
  std::vector<double> errors;
  Projected projected;
  for (const Correspondence& c : points)
    errors.push_back(project<Slopes::None>(in, lens, pose * c.position, projected)
                         ? (projected.pixel - c.pixel).norm()
                         : kInfinity);
  return errors.empty() ? kInfinity : median(std::move(errors));
}

}  // namespace

double homography_error(const std::vector<Correspondence>& points) {
  if (points.size() < 5) return kInfinity;  // four points always fit
  const Plane plane = plane_of(points);
  std::vector<Vector2d> flat, pixels;
  for (const Correspondence& c : points) {
    flat.push_back((plane.axes.transpose() * (c.position - plane.center)).head<2>());
    pixels.push_back(c.pixel);
  }
  const std::optional<Matrix3d> h = fit_homography(flat, pixels);
  if (!h) return kInfinity;
  std::vector<double> errors;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const std::optional<Vector2d> p = apply(*h, flat[i]);
    errors.push_back(p ? (*p - pixels[i]).norm() : kInfinity);
  }
  return median(std::move(errors));
}

ViewPose refine_pose(const Intrinsics& in, LensKind lens, const std::vector<Correspondence>& points,
                     const Rigid3& start, int iterations) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Rigid3 pose = start;
  double damping = 1e-6, scale = std::max(1.0, 3 * median_error(in, lens, points, start));
  const auto cost_of = [&](const Rigid3& p, Matrix6* normal, Vector6* gradient) {
    double cost = 0;
    Projected projected;
    for (const Correspondence& c : points) {
      const Vector3d x = p * c.position;
      if (!(normal ? project<Slopes::ByPoint>(in, lens, x, projected)
                   : project<Slopes::None>(in, lens, x, projected))) {
        cost += std::log1p(1e6);
        continue;
      }
      const Vector2d e = (projected.pixel - c.pixel) / scale;
      const double weight = 1 / (1 + e.squaredNorm());
      cost += std::log1p(e.squaredNorm());
      if (!normal) continue;
      Eigen::Matrix<double, 2, 6> j;
      j << -projected.by_point * cross_matrix(x), projected.by_point;
      j /= scale;
      *normal += weight * j.transpose() * j;
      *gradient += weight * j.transpose() * e;
    }
    return cost;
  };
  for (int i = 0; i < iterations; ++i) {
    Matrix6 normal = Matrix6::Zero();
    Vector6 gradient = Vector6::Zero();
    const double cost = cost_of(pose, &normal, &gradient);
    bool better = false;
    for (int attempt = 0; attempt < 6 && !better; ++attempt, damping *= 10) {
      Matrix6 damped = normal;
      damped.diagonal() *= 1 + damping;
      const Vector6 step = -damped.ldlt().solve(gradient);
      if (!step.allFinite()) continue;
      const Eigen::Quaterniond turn = rotation_from_vector(step.head<3>());
      const Rigid3 next{(turn * pose.rotation).normalized(), turn * pose.translation + step.tail<3>()};
      const double then = cost_of(next, nullptr, nullptr);
      if (!(then < cost)) continue;
      better = true;
      pose = next;
      damping = std::max(damping / 100, 1e-9);
      if (cost - then < 1e-9 * cost) return {pose, median_error(in, lens, points, pose)};
    }
    if (!better) break;
    scale = std::max(1.0, std::min(scale, 3 * median_error(in, lens, points, pose)));
  }
  return {pose, median_error(in, lens, points, pose)};
}

std::optional<ViewPose> view_pose(const Intrinsics& in, LensKind lens, int width, int height,
                                  const std::vector<Correspondence>& points) {
  const CameraModel model = unpack(in, lens, width, height);
  std::vector<Vector3d> positions;
  std::vector<Vector2d> rays;
  std::vector<Correspondence> used;
  for (const Correspondence& c : points)
    if (const std::optional<Vector3d> ray = unproject(model, c.pixel)) {
      positions.push_back(c.position);
      rays.push_back(ray->head<2>());
      used.push_back(c);
    }
  if (used.size() < 4) return std::nullopt;
  const Plane plane = plane_of(used);
  if (plane.thin) return std::nullopt;
  const std::optional<Rigid3> direct =
      plane.flat ? pose_of_flat(plane, positions, rays) : pose_of_solid(plane, positions, rays);
  if (!direct || !direct->translation.allFinite()) return std::nullopt;
  ViewPose best = refine_pose(in, lens, points, *direct);
  if (plane.flat) {
    // The other tilt: the board's normal mirrored at the line of sight, to which it turns half of the way.
    const Vector3d center = best.cam_from_target * plane.center, sight = center.normalized();
    const Vector3d normal = best.cam_from_target.rotation * plane.axes.col(2);
    const Vector3d axis = normal.cross(sight);
    const Eigen::Quaterniond turn(normal.dot(sight), axis.x(), axis.y(), axis.z());
    const Rigid3 other{(turn * best.cam_from_target.rotation).normalized(),
                       turn * (best.cam_from_target.translation - center) + center};
    const ViewPose flipped = refine_pose(in, lens, points, other);
    if (flipped.error < best.error) best = flipped;
  }
  if (!std::isfinite(best.error)) return std::nullopt;
  return best;
}

}  // namespace floatstage::calib::solver
