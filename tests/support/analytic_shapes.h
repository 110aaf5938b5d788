#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::shapes {

/// A body of which only its silhouette is needed: does the ray from `origin` along `direction` meet it?
using Shape = std::function<bool(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)>;

Shape sphere(const Eigen::Vector3d& center, double radius);
/// Axis-parallel.
Shape box(const Eigen::Vector3d& center, const Eigen::Vector3d& sizes);
/// Around the z axis of `center`; `ring` is the radius of the circle in the middle of its tube.
Shape torus(const Eigen::Vector3d& center, double ring, double tube);
Shape both(Shape a, Shape b);

/// What the camera would see: alpha is the covered part of each pixel, from 8×8 rays through its lens.
Matte render_matte(const RigCamera& camera, const Shape& shape);
std::vector<Matte> render_mattes(const Rig& rig, const Shape& shape);

Matte uniform_matte(const RigCamera& camera, std::uint8_t alpha);

struct RigShape {
  int cameras = 8;
  double distance = 3;  ///< metres, from the target
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  int width = 160, height = 120;
  double focal = 150;  ///< px
  Lens lens = {};
};

/// Cameras on a circle in the plane z = target.z + height, looking at the target.
Rig ring_rig(const RigShape& shape, double height = 0.8);
/// Cameras spread evenly over the whole sphere (a Fibonacci spiral).
Rig sphere_rig(const RigShape& shape);

}  // namespace floatstage::shapes
