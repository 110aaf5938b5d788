#pragma once

#include <array>

#include <Eigen/Geometry>

#include "core/rig.h"

namespace floatstage::render {

/// Where a camera's depth map lies: ideal pinhole coordinates (x/z, y/z), so that one map serves any lens.
struct DepthWindow {
  std::array<float, 4> place{};  ///< depth map pixel = xy * (x/z, y/z) + zw
  int width = 2, height = 2;     ///< texels, at least 2
  float near_plane = 0, far_plane = 0;
};

/// A camera's depth map over the part of its picture that `box` can cover, one texel a photograph pixel:
/// finer shows nothing that the photograph has, coarser blurs occlusion borders.
DepthWindow depth_window(const RigCamera& camera, const Eigen::AlignedBox3f& box);

/// How far behind a depth map a point of a proxy with this box is still seen, metres.
double depth_tolerance(const Eigen::AlignedBox3f& box);

}  // namespace floatstage::render
