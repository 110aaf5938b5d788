#include "core/camera.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace floatstage {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

struct Distorted {
  Vector2d point;
  Matrix2d jacobian;  // of point by the normalised input
};

/// Numerator and denominator of the radial factor at q = r², and their derivatives by q.
struct RadialTerms {
  double above, d_above, below, d_below;
};

RadialTerms radial_terms(const BrownConrady& l, double q) {
  return {1 + q * (l.k1 + q * (l.k2 + q * l.k3)), l.k1 + q * (2 * l.k2 + 3 * q * l.k3),
          1 + q * (l.k4 + q * (l.k5 + q * l.k6)), l.k4 + q * (2 * l.k5 + 3 * q * l.k6)};
}

Distorted distort_with_jacobian(const BrownConrady& l, const Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const RadialTerms t = radial_terms(l, r2);
  const double radial = t.above / t.below;
  const double d_radial = (t.d_above - radial * t.d_below) / t.below;  // by r²
  Distorted d;
  d.point = {x * radial + 2 * l.p1 * x * y + l.p2 * (r2 + 2 * x * x),
             y * radial + l.p1 * (r2 + 2 * y * y) + 2 * l.p2 * x * y};
  d.jacobian(0, 0) = radial + 2 * x * x * d_radial + 2 * l.p1 * y + 6 * l.p2 * x;
  d.jacobian(0, 1) = 2 * x * y * d_radial + 2 * l.p1 * x + 2 * l.p2 * y;
  d.jacobian(1, 0) = d.jacobian(0, 1);
  d.jacobian(1, 1) = radial + 2 * y * y * d_radial + 6 * l.p1 * y + 2 * l.p2 * x;
  return d;
}

// The radial curve r·(1 + k1 r² + …)/(1 + k4 r² + …) must still be rising at r, and at every smaller radius,
// and must not have run through a pole.
bool monotonic_until(const BrownConrady& l, double r2) {
  // Without a denominator the slope is a cubic in r² with at most three roots, with one of sixth degree: the
  // samples find a dip wide enough to matter.
  const int steps = l.rational() ? 16 : 8;
  for (int i = 1; i <= steps; ++i)
    if (!radial_rises(l, r2 * i / steps)) return false;
  return true;
}

double fisheye_radius(const KannalaBrandt& l, double theta) {
  const double q = theta * theta;
  return theta * (1 + q * (l.k1 + q * (l.k2 + q * (l.k3 + q * l.k4))));
}

double fisheye_slope(const KannalaBrandt& l, double theta) {
  const double q = theta * theta;
  return 1 + q * (3 * l.k1 + q * (5 * l.k2 + q * (7 * l.k3 + q * 9 * l.k4)));
}

constexpr double kConverged = 1e-12;
constexpr int kMaxIterations = 30;

}  // namespace

Eigen::Matrix3d CameraModel::k() const {
  Eigen::Matrix3d m;
  m << fx, skew, cx, 0, fy, cy, 0, 0, 1;
  return m;
}

Rigid3 Rigid3::inverse() const {
  const Eigen::Quaterniond r = rotation.conjugate();
  return {r, r * -translation};
}

Eigen::Matrix4d Rigid3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = translation;
  return m;
}

Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = z.cross(up);
  FLOATSTAGE_CHECK(x.norm() > 1e-9 * up.norm(), "look_at with `up` along the viewing direction");
  Eigen::Matrix3d camera_from_world;
  camera_from_world.row(0) = x.normalized();
  camera_from_world.row(1) = z.cross(x.normalized());
  camera_from_world.row(2) = z;
  Rigid3 result;
  result.rotation = Eigen::Quaterniond(camera_from_world).normalized();
  result.translation = result.rotation * -eye;
  return result;
}

double radial_factor(const BrownConrady& l, double r2) {
  const RadialTerms t = radial_terms(l, r2);
  return t.above / t.below;
}

bool radial_rises(const BrownConrady& l, double r2) {
  const RadialTerms t = radial_terms(l, r2);
  // The sign of d(r above/below)/dr · below².
  return t.below > 0 && (t.above + 2 * r2 * t.d_above) * t.below > 2 * r2 * t.above * t.d_below;
}

std::optional<Vector2d> distort(const Lens& lens, const Vector2d& n) {
  if (const auto* brown = std::get_if<BrownConrady>(&lens)) {
    if (!monotonic_until(*brown, n.squaredNorm())) return std::nullopt;
    return distort_with_jacobian(*brown, n).point;
  }
  if (const auto* fisheye = std::get_if<KannalaBrandt>(&lens)) {
    const double r = n.norm();
    if (r < 1e-12) return n;
    return n * (fisheye_radius(*fisheye, std::atan(r)) / r);
  }
  return n;
}

std::optional<Vector2d> undistort(const Lens& lens, const Vector2d& distorted) {
  if (const auto* brown = std::get_if<BrownConrady>(&lens)) {
    Vector2d n = distorted;
    for (int i = 0; i < kMaxIterations; ++i) {
      const Distorted d = distort_with_jacobian(*brown, n);
      const Vector2d step = d.jacobian.inverse() * (distorted - d.point);
      if (!step.allFinite()) return std::nullopt;
      n += step;
      if (step.norm() < kConverged) {
        if (!monotonic_until(*brown, n.squaredNorm())) return std::nullopt;
        return n;
      }
    }
    return std::nullopt;
  }
  if (const auto* fisheye = std::get_if<KannalaBrandt>(&lens)) {
    const double r = distorted.norm();
    if (r < 1e-12) return distorted;
    double theta = r;
    for (int i = 0; i < kMaxIterations; ++i) {
      const double slope = fisheye_slope(*fisheye, theta);
      if (slope <= 0) return std::nullopt;
      const double step = (r - fisheye_radius(*fisheye, theta)) / slope;
      theta += step;
      if (std::abs(step) < kConverged) {
        if (theta <= 0 || theta >= 1.57) return std::nullopt;  // at or behind the image plane at infinity
        return distorted * (std::tan(theta) / r);
      }
    }
    return std::nullopt;
  }
  return distorted;
}

std::optional<Vector2d> project(const CameraModel& m, const Eigen::Vector3d& p) {
  if (!(p.z() > 0)) return std::nullopt;
  const std::optional<Vector2d> d = distort(m.lens, p.head<2>() / p.z());
  if (!d) return std::nullopt;
  return Vector2d(m.fx * d->x() + m.skew * d->y() + m.cx, m.fy * d->y() + m.cy);
}

std::optional<std::vector<Vector2d>> project_all(const CameraModel& m, const Rigid3& cam_from_world,
                                                 std::span<const Eigen::Vector3f> points) {
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  std::vector<Vector2d> pixels;
  pixels.reserve(points.size());
  double farthest = 0;
  for (const Eigen::Vector3f& world : points) {
    const Eigen::Vector3d p = rotation * world.cast<double>() + cam_from_world.translation;
    if (!(p.z() > 0)) return std::nullopt;
    pixels.emplace_back(p.head<2>() / p.z());
    farthest = std::max(farthest, pixels.back().squaredNorm());
  }
  const auto* brown = std::get_if<BrownConrady>(&m.lens);
  if (brown != nullptr && !monotonic_until(*brown, farthest)) return std::nullopt;
  for (Vector2d& pixel : pixels) {
    const std::optional<Vector2d> d =
        brown != nullptr ? distort_with_jacobian(*brown, pixel).point : distort(m.lens, pixel);
    if (!d) return std::nullopt;
    pixel = {m.fx * d->x() + m.skew * d->y() + m.cx, m.fy * d->y() + m.cy};
  }
  return pixels;
}

std::optional<Eigen::Vector3d> unproject(const CameraModel& m, const Vector2d& pixel) {
  const double y = (pixel.y() - m.cy) / m.fy;
  const double x = (pixel.x() - m.cx - m.skew * y) / m.fx;
  const std::optional<Vector2d> n = undistort(m.lens, {x, y});
  if (!n) return std::nullopt;
  return Eigen::Vector3d(n->x(), n->y(), 1);
}

bool inside(const CameraModel& m, const Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < m.width && p.y() < m.height;
}

CameraModel pinhole(CameraModel model) {
  model.lens = std::monostate{};
  return model;
}

Result<void> check(const CameraModel& m) {
  if (m.width <= 0 || m.height <= 0)
    return fail(ErrorCode::BadData, text("image size ", m.width, "x", m.height, " is not positive"));
  for (double v : {m.fx, m.fy, m.cx, m.cy, m.skew})
    if (!std::isfinite(v)) return fail(ErrorCode::BadData, "an intrinsic parameter is not a finite number");
  if (m.fx <= 0 || m.fy <= 0)
    return fail(ErrorCode::BadData, text("focal length ", m.fx, ", ", m.fy, " is not positive"));
  const bool lens_finite = std::visit(
      [](const auto& l) {
        using L = std::decay_t<decltype(l)>;
        if constexpr (std::is_same_v<L, BrownConrady>)
          return std::isfinite(l.k1 + l.k2 + l.p1 + l.p2 + l.k3 + l.k4 + l.k5 + l.k6);
        else if constexpr (std::is_same_v<L, KannalaBrandt>)
          return std::isfinite(l.k1 + l.k2 + l.k3 + l.k4);
        else
          return true;
      },
      m.lens);
  if (!lens_finite) return fail(ErrorCode::BadData, "a lens coefficient is not a finite number");
  return {};
}

}  // namespace floatstage
