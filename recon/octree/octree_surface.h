#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "recon/octree/octree_carve.h"

namespace floatstage::recon {

/// A triangle mesh in double precision, for the work between carving and the final Mesh. Metres,
/// counter-clockwise seen from outside.
struct Surface {
  std::vector<Eigen::Vector3d> positions;
  /// For each vertex a place, near its own, such that no triangles cross when all are there.
  std::vector<Eigen::Vector3d> safe_positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The surface between the inside and the outside points of a carved grid: a closed oriented manifold, one
/// vertex on every grid edge with two different ends. Vertices lie where the edge really leaves the hull,
/// found by bisection against the mattes (not where interpolation between grid values would guess), but not
/// nearer than 2 % of a voxel to a grid point, so that no triangle is without area. Triangles of two cells
/// never cross; two of one cell may, in rare arrangements, unless their vertices move to the safe positions,
/// the middles of their grid edges. The same bytes at any thread count.
Surface extract_surface(const CarvedGrid& grid, std::span<const OctreeView> views, int threads);

}  // namespace floatstage::recon
