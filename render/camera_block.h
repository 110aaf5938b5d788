#pragma once

#include <array>

#include <Eigen/Geometry>

#include "core/rig.h"

namespace floatstage::render {

/// One camera as the shaders read it (std430; gl/shaders/camera.glsl has the twin).
struct CameraBlock {
  std::array<float, 16> cam_from_world;  ///< column by column
  std::array<float, 4> center;           ///< world
  std::array<float, 4> intrinsics;       ///< fx, fy, cx, cy
  std::array<float, 4> lens;             ///< Brown-Conrady k1 k2 p1 p2, or fisheye k1 k2 k3 k4
  std::array<float, 4> lens_more;   ///< Brown-Conrady k3, skew, largest r² the lens is good for, lens type
  std::array<float, 4> lens_below;  ///< Brown-Conrady k4 k5 k6: the radial factor's denominator; 0
  std::array<float, 4> image;       ///< width, height, layer, 0
  std::array<float, 4> depth;       ///< depth map pixel = xy * (x/z, y/z) + zw
  std::array<float, 4> tile;        ///< the part of the picture in its layer: x, y, width, height
};
static_assert(sizeof(CameraBlock) == 192);

/// The square of the largest normalised radius up to which the lens is monotonic: farther points fold back
/// into the picture and must not be looked up.
double largest_radius2(const Lens& lens);

/// The part of a camera's picture, in ideal pinhole coordinates (x/z, y/z), that a box can project to, grown
/// by a guard of `guard_px` photograph pixels. Never empty.
Eigen::AlignedBox2d pinhole_bounds(const RigCamera& camera, const Eigen::AlignedBox3f& box, double guard_px);

/// Everything but `depth`, which the depth maps fill in; the tile is the whole picture.
CameraBlock camera_block(const RigCamera& camera, int layer);

}  // namespace floatstage::render
