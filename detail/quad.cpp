#include "detail/quad.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/SVD>

namespace floatstage::detail {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostAreaChange = 4, kMostSqueeze = 2;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_of_polygon(const std::vector<Vector2d>& p) {
  double twice = 0;
  for (std::size_t i = 0; i < p.size(); ++i) twice += cross(p[i], p[(i + 1) % p.size()]);
  return twice / 2;
}

// How a small step becomes a step.
Matrix2d jacobian(const Matrix3d& h, const Vector2d& at) {
  const Vector3d p = h * at.homogeneous();
  const Vector2d q = p.hnormalized();
  return (h.topLeftCorner<2, 2>() - q * h.block<1, 2>(2, 0)) / p.z();
}

// The part of a convex polygon where normal·x <= limit (I. Sutherland, G. Hodgman 1974).
std::vector<Vector2d> clipped(const std::vector<Vector2d>& polygon, const Vector2d& normal, double limit) {
  std::vector<Vector2d> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a) - limit, db = normal.dot(b) - limit;
    if (da <= 0) out.push_back(a);
    if ((da <= 0) != (db <= 0)) out.push_back(a + (b - a) * (da / (da - db)));
  }
  return out;
}

}  // namespace

std::optional<Vector2d> transformed(const Matrix3d& homography, const Vector2d& point) {
  const Vector3d p = homography * point.homogeneous();
  if (!(p.z() > 1e-9)) return std::nullopt;
  return p.hnormalized();
}

std::optional<Quad> sane_quad(const Matrix3d& h, int width, int height) {
  if (!h.allFinite()) return std::nullopt;
  const double w = width, t = height;
  const std::array<Vector2d, 4> corners = {Vector2d(0, 0), Vector2d(w, 0), Vector2d(w, t), Vector2d(0, t)};
  Quad quad;
  double least = 0, most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::optional<Vector2d> at = transformed(h, corners[i]);
    if (!at) return std::nullopt;
    quad[i] = *at;
    const double area = jacobian(h, corners[i]).determinant();
    if (!(area > 0)) return std::nullopt;
    least = i == 0 ? area : std::min(least, area);
    most = std::max(most, area);
  }
  for (std::size_t i = 0; i < 4; ++i)
    if (cross(quad[(i + 1) % 4] - quad[i], quad[(i + 2) % 4] - quad[(i + 1) % 4]) <= 0) return std::nullopt;
  const Eigen::JacobiSVD<Matrix2d> middle(jacobian(h, {w / 2, t / 2}));
  const Vector2d stretch = middle.singularValues();
  if (most > kMostAreaChange * least || stretch[0] > kMostSqueeze * stretch[1]) return std::nullopt;
  return quad;
}

double area_of(const Quad& quad) { return area_of_polygon({quad.begin(), quad.end()}); }

double share_inside(const Quad& quad, int width, int height) {
  std::vector<Vector2d> inside(quad.begin(), quad.end());
  inside = clipped(inside, {-1, 0}, 0);
  inside = clipped(inside, {0, -1}, 0);
  inside = clipped(inside, {1, 0}, width);
  inside = clipped(inside, {0, 1}, height);
  const double whole = area_of(quad);
  return whole > 0 ? std::clamp(area_of_polygon(inside) / whole, 0.0, 1.0) : 0;
}

}  // namespace floatstage::detail
