#include "calib/solver/ring.h"

#include <Eigen/Dense>

namespace floatstage::calib::solver {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d Ring::off(const Vector3d& point) const {
  const Vector3d d = point - center;
  const double along = d.dot(axis);
  return {along, (d - along * axis).norm() - radius};
}

std::optional<Ring> fit_ring(std::span<const Vector3d> points) {
  const auto n = static_cast<Eigen::Index>(points.size());
  if (n < 4) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(n);
  Eigen::MatrixX3d spread(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) spread.row(i) = points[static_cast<std::size_t>(i)] - mean;
  const Eigen::JacobiSVD<Eigen::MatrixX3d> svd(spread, Eigen::ComputeFullV);
  constexpr double kInLine = 1e-3;  // of the longest side: no circle is seen in less
  if (!(svd.singularValues()[1] > kInLine * svd.singularValues()[0])) return std::nullopt;
  const Vector3d u = svd.matrixV().col(0), v = svd.matrixV().col(1);
  // |p|² = 2 p·c + (r² - |c|²) is linear in c and the bracket.
  Eigen::MatrixX3d a(n, 3);
  Eigen::VectorXd squares(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector2d p(spread.row(i).dot(u), spread.row(i).dot(v));
    a.row(i) << 2 * p.x(), 2 * p.y(), 1;
    squares[i] = p.squaredNorm();
  }
  const Vector3d solved = a.colPivHouseholderQr().solve(squares);
  const double radius2 = solved[2] + solved.head<2>().squaredNorm();
  if (!solved.allFinite() || !(radius2 > 0)) return std::nullopt;
  return Ring{mean + solved[0] * u + solved[1] * v, u.cross(v).normalized(), std::sqrt(radius2)};
}

}  // namespace floatstage::calib::solver
