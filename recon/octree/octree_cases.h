#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace floatstage::recon {

/// Marching cubes (Lorensen and Cline 1987) with a table that is derived, not typed in, and whose surface is
/// a manifold for every arrangement of signs.
///
/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge 4 axis + k runs along `axis`; k's two
/// bits are its position on the other two axes, in the order x, y, z.
struct CubeEdge {
  int axis;
  std::array<int, 3> from;  ///< offset of its lower end
  std::array<int, 2> corners;
};

CubeEdge cube_edge(int edge);

/// Triangles of each of the 256 arrangements of inside corners (bit c: corner c is inside), three cube edges
/// each, counter-clockwise seen from outside.
///
/// On a face with two diagonal inside corners, the inside corners are kept apart: both cells at the face
/// decide by the same four signs, so their outlines agree and no crack opens. Each outline is closed by
/// triangles none of whose inner edges joins two points of one cube face, so that an inner edge belongs to
/// one cell alone: every edge of the whole surface has exactly two triangles.
using CubeCases = std::array<std::vector<std::array<std::uint8_t, 3>>, 256>;
CubeCases make_cube_cases();

}  // namespace floatstage::recon
