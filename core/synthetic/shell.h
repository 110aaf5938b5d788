#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace floatstage::synthetic {

/// A closed surface in its own rest coordinates: metres, counter-clockwise outside. The rest position doubles
/// as the solid texture coordinate, so a texture sticks to the surface however it is bent later, and has no
/// seam.
struct Shell {
  std::vector<Eigen::Vector3d> rest;
  std::vector<std::uint32_t> triangles;
};

/// One cross-section of a tube: an ellipse (superellipse) of half-widths `a` along x and `b` along y, centred
/// at y.
struct Section {
  double z = 0, a = 0, b = 0, y = 0;
};

struct TubeOptions {
  int rings = 32, segments = 32;
  double near_cap = 0.02, far_cap = 0.02;  ///< metres that the rounded ends stand out along z
  double exponent = 2;                     ///< 2 an ellipse; more is squarer
};

/// A smooth tube through the sections (ascending z; interpolated by Catmull-Rom), closed by rounded ends.
Shell tube(const std::vector<Section>& sections, const TubeOptions& options);

/// A sphere of directions, each moved to place(direction); poles on ±z. `place` must keep the surface
/// outward.
Shell blob(int rings, int segments, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& place);

/// Moves every rest position; `where` must preserve orientation.
Shell moved(Shell shell, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& where);

}  // namespace floatstage::synthetic
