#include "calib/formats/camera_parts.h"

#include <cctype>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "core/serial.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr double kHalfPixel = 0.5;

}  // namespace

Result<Eigen::Quaterniond> rotation_from_matrix(const Eigen::Matrix3d& matrix) {
  if (!matrix.allFinite()) return fail(ErrorCode::BadData, "the rotation holds a number that is not finite");
  const double error = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kLargestRotationError))
    return fail(ErrorCode::BadData,
                text("the rotation is not orthonormal (off by ", error, ", at most ", kLargestRotationError,
                     " is taken for rounding); it may be scaled, transposed wrongly or damaged"));
  if (matrix.determinant() < 0)
    return fail(ErrorCode::BadData,
                "the rotation is a mirror (determinant -1); the file's handedness is wrong");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())).normalized();
}

double to_corner_origin(double principal_point, PixelOrigin origin) {
  return origin == PixelOrigin::FirstPixelCenter ? principal_point + kHalfPixel : principal_point;
}

double from_corner_origin(double principal_point, PixelOrigin origin) {
  return origin == PixelOrigin::FirstPixelCenter ? principal_point - kHalfPixel : principal_point;
}

Result<void> set_k(CameraModel& model, const Eigen::Matrix3d& k, PixelOrigin origin) {
  if (!k.allFinite()) return fail(ErrorCode::BadData, "K holds a number that is not finite");
  if (k(1, 0) != 0 || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1)
    return fail(ErrorCode::BadData, "K is not of the form [fx s cx; 0 fy cy; 0 0 1]");
  if (k(0, 0) <= 0 || k(1, 1) <= 0)
    return fail(ErrorCode::BadData, text("the focal length ", k(0, 0), ", ", k(1, 1), " is not positive"));
  model.fx = k(0, 0);
  model.fy = k(1, 1);
  model.skew = k(0, 1);
  model.cx = to_corner_origin(k(0, 2), origin);
  model.cy = to_corner_origin(k(1, 2), origin);
  return {};
}

Eigen::Matrix3d k_with_origin(const CameraModel& model, PixelOrigin origin) {
  Eigen::Matrix3d k = model.k();
  k(0, 2) = from_corner_origin(k(0, 2), origin);
  k(1, 2) = from_corner_origin(k(1, 2), origin);
  return k;
}

std::string serial_from_name(std::string_view name) {
  std::string serial(without_media_extension(name));
  for (char& c : serial)
    if (!(std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-')) c = '_';
  if (!serial.empty() && serial.front() == '.') serial.front() = '_';
  return serial;
}

}  // namespace floatstage::calib
