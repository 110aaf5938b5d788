#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/result.h"

namespace floatstage::calib {

/// What the readers of all formats do with the pieces of a camera. Messages say what is wrong with the piece;
/// the caller adds file, line and camera.

/// Entries of RᵀR may be this far from the identity: files round to a few digits. Beyond it the file is
/// wrong.
inline constexpr double kLargestRotationError = 1e-3;

/// The rotation nearest to a nearly orthonormal matrix (polar decomposition). A mirror (determinant below 0)
/// and a matrix further off than kLargestRotationError are BadData.
Result<Eigen::Quaterniond> rotation_from_matrix(const Eigen::Matrix3d& matrix);

/// Where a format has its origin: at the centre of the first pixel (OpenCV, Middlebury, Qualisys) or at the
/// corner of the image, as we do. The half pixel between them is added and taken away nowhere else.
enum class PixelOrigin { FirstPixelCenter, ImageCorner };

double to_corner_origin(double principal_point, PixelOrigin origin);
double from_corner_origin(double principal_point, PixelOrigin origin);

/// Fills the focal lengths, skew and principal point from K = [fx s cx; 0 fy cy; 0 0 1]. BadData when K is
/// not of this form or not finite.
Result<void> set_k(CameraModel& model, const Eigen::Matrix3d& k, PixelOrigin origin);
Eigen::Matrix3d k_with_origin(const CameraModel& model, PixelOrigin origin);

/// A name made usable as a serial (and so as a file name): '/' and everything else that may not stand in one
/// becomes
/// '_'. Different names may become one; check(Rig) finds that.
std::string serial_from_name(std::string_view name);

}  // namespace floatstage::calib
