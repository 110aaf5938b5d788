#pragma once

#include <optional>
#include <span>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/result.h"

namespace floatstage {

/// Radial-tangential lens, OpenCV's model and order: x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴
/// + k6 r⁶) + 2 p1 xy + p2 (r² + 2x²). With k4 = k5 = k6 = 0 it is Brown's polynomial; with them the rational
/// model (Claus and Fitzgibbon 2005 is its ancestor) of wide lenses that are not yet fisheyes.
struct BrownConrady {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  bool rational() const { return k4 != 0 || k5 != 0 || k6 != 0; }
  bool operator==(const BrownConrady&) const = default;
};

/// Equidistant fisheye (OpenCV `fisheye`): θd = θ(1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸).
struct KannalaBrandt {
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
  bool operator==(const KannalaBrandt&) const = default;
};

/// monostate is an ideal pinhole.
using Lens = std::variant<std::monostate, BrownConrady, KannalaBrandt>;

/// Intrinsics in pixels. The top-left corner of the image is (0,0); the first pixel's centre is (0.5,0.5).
struct CameraModel {
  int width = 0, height = 0;  ///< px
  double fx = 0, fy = 0;      ///< px
  double cx = 0, cy = 0;      ///< px, corner convention
  double skew = 0;            ///< px: u = fx x + skew y + cx; 0 for every modern sensor
  Lens lens;
  bool operator==(const CameraModel&) const = default;

  Eigen::Matrix3d k() const;
};

/// A rotation and a translation in metres. `b_from_a * x_in_a` is x in b. Never a bare "pose".
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  Rigid3 operator*(const Rigid3& o) const {
    return {rotation * o.rotation, rotation * o.translation + translation};
  }
  Rigid3 inverse() const;
  /// For `cam_from_world`: where the camera stands, in the world.
  Eigen::Vector3d center() const { return rotation.conjugate() * -translation; }
  Eigen::Matrix4d matrix() const;
};

/// The transform of a camera at `eye` that looks at `target`, x right, y down, z forward, with `up` upwards
/// in the picture. `up` must not be parallel to the viewing direction.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

/// Applies the lens to a normalised image point (x/z, y/z). Brown-Conrady folds over far outside its image:
/// points beyond the radius where the model stops being monotonic come back as absent.
std::optional<Eigen::Vector2d> distort(const Lens& lens, const Eigen::Vector2d& normalized);

/// The radial factor (1 + k1 r² + …) / (1 + k4 r² + …) at r2 = r².
double radial_factor(const BrownConrady& lens, double r2);

/// Whether the radial curve r · radial_factor still rises at r2 = r² (and its denominator is positive): where
/// it does not, the lens folds over.
bool radial_rises(const BrownConrady& lens, double r2);

/// Inverse of distort(), by Newton iteration to 1e-12; absent where it does not converge.
std::optional<Eigen::Vector2d> undistort(const Lens& lens, const Eigen::Vector2d& distorted);

/// Pixel of a point in camera coordinates; absent when z <= 0 or the lens cannot see it. May lie outside the
/// image.
std::optional<Eigen::Vector2d> project(const CameraModel& model, const Eigen::Vector3d& in_camera);

/// The same of many points, in the world, in a sixth of the time; absent when the camera cannot see one of
/// them.
std::optional<std::vector<Eigen::Vector2d>> project_all(const CameraModel& model,
                                                        const Rigid3& cam_from_world,
                                                        std::span<const Eigen::Vector3f> points);

/// Direction (z = 1, camera coordinates) of the ray through a pixel; absent where the lens cannot be
/// inverted.
std::optional<Eigen::Vector3d> unproject(const CameraModel& model, const Eigen::Vector2d& pixel);

bool inside(const CameraModel& model, const Eigen::Vector2d& pixel);

/// The same camera without its lens: what undistorted pictures are rendered with.
CameraModel pinhole(CameraModel model);

/// Sizes positive, every number finite, focal lengths positive; the sentence says which is not.
Result<void> check(const CameraModel& model);

}  // namespace floatstage
