#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace floatstage::detail {

/// A picture's corners, clockwise from the top left, in another's pixels.
using Quad = std::array<Eigen::Vector2d, 4>;

/// The point to which a homography takes another; absent where it has none in front of it.
std::optional<Eigen::Vector2d> transformed(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point);

/// What a picture of width x height becomes; absent where it folds over, is mirrored, lies partly behind or
/// is seen so obliquely that no photograph of the same subject is: local areas differ by more than 4 within
/// it, or it is squeezed more than twofold in a direction.
std::optional<Quad> sane_quad(const Eigen::Matrix3d& homography, int width, int height);

/// Area in px², positive for clockwise.
double area_of(const Quad& quad);

/// How much of a convex quad lies in the picture of width x height, 0 to 1.
double share_inside(const Quad& quad, int width, int height);

}  // namespace floatstage::detail
