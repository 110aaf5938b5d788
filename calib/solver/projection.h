#pragma once

#include <array>

#include <Eigen/Core>

#include "calib/observations.h"

namespace floatstage::calib::solver {

/// fx fy cx cy, then eight of the lens' coefficients in the order of its struct, then the skew; those that a
/// lens lacks are 0 and stay so.
inline constexpr int kIntrinsics = 13;
inline constexpr int kLensRow = 4, kLensRows = 8, kSkewRow = 12;
/// Of a Brown-Conrady lens: p1 and p2, and its six radial terms in their order; the last three are the
/// denominator.
inline constexpr int kTangentialRow = kLensRow + 2;
inline constexpr std::array<int, 6> kRadialRows = {kLensRow,     kLensRow + 1, kLensRow + 4,
                                                   kLensRow + 5, kLensRow + 6, kLensRow + 7};
inline constexpr int kDenominatorRow = kLensRow + 5;
using Intrinsics = Eigen::Matrix<double, kIntrinsics, 1>;

/// Coefficients of a lens: 0, 8 or 4.
int coefficient_count(LensKind lens);

Intrinsics pack(const CameraModel& model);
CameraModel unpack(const Intrinsics& intrinsics, LensKind lens, int width, int height);

/// A pixel and how it changes. Unlike core's project(), Brown-Conrady is the bare formula here: while it
/// is being solved for, a lens may fold over where it will not in the end.
struct Projected {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  ///< by the point in camera coordinates
  Eigen::Matrix<double, 2, kIntrinsics> by_intrinsics;
};

/// What of a Projected is wanted; the rest is left as it is.
enum class Slopes { None, ByPoint, All };

/// False where the point is not in front of the camera, or lies beyond a pole of the lens.
template <Slopes = Slopes::All>
bool project(const Intrinsics& intrinsics, LensKind lens, const Eigen::Vector3d& in_camera, Projected& out);
extern template bool project<Slopes::None>(const Intrinsics&, LensKind, const Eigen::Vector3d&, Projected&);
extern template bool project<Slopes::ByPoint>(const Intrinsics&, LensKind, const Eigen::Vector3d&,
                                              Projected&);
extern template bool project<Slopes::All>(const Intrinsics&, LensKind, const Eigen::Vector3d&, Projected&);

}  // namespace floatstage::calib::solver
