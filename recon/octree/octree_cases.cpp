// Method:  the table of marching cubes, derived
// Paper:   W. E. Lorensen, H. E. Cline, "Marching cubes", 1987
// Differs: faces with two crossings are decided by one rule for both cells, so that the surface is a closed
//          manifold
// ADR:     0051

#include "recon/octree/octree_cases.h"

#include <span>
#include <utility>

#include "core/check.h"
#include "core/text.h"

namespace floatstage::recon {
namespace {

int corner_at(const std::array<int, 3>& p) { return p[0] | p[1] << 1 | p[2] << 2; }

int edge_between(int a, int b) {
  for (int edge = 0; edge < 12; ++edge) {
    const CubeEdge e = cube_edge(edge);
    if ((e.corners[0] == a && e.corners[1] == b) || (e.corners[0] == b && e.corners[1] == a)) return edge;
  }
  FLOATSTAGE_CHECK(false, text("no cube edge between corners ", a, " and ", b));
}

// The four corners of a face, counter-clockwise seen from outside the cube.
std::array<int, 4> face_corners(int axis, int side) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::array<int, 4> corners;
  for (int i = 0; i < 4; ++i) {
    const int turn = side ? i : 3 - i;
    std::array<int, 3> p{};
    p[static_cast<std::size_t>(axis)] = side;
    p[static_cast<std::size_t>(u)] = turn == 1 || turn == 2;
    p[static_cast<std::size_t>(v)] = turn >= 2;
    corners[static_cast<std::size_t>(i)] = corner_at(p);
  }
  return corners;
}

bool share_a_face(int edge_a, int edge_b) {
  const CubeEdge a = cube_edge(edge_a), b = cube_edge(edge_b);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (static_cast<int>(axis) != a.axis && static_cast<int>(axis) != b.axis && a.from[axis] == b.from[axis])
      return true;
  return false;
}

// next[e] is the cube edge that follows e on its outline, or -1 where the surface does not cross e.
std::array<int, 12> outlines(int inside) {
  std::array<int, 12> next;
  next.fill(-1);
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const std::array<int, 4> face = face_corners(axis, side);
      auto is_inside = [&](std::size_t i) { return (inside >> face[i % 4]) & 1; };
      for (std::size_t i = 0; i < 4; ++i) {
        if (!is_inside(i) || is_inside(i + 3)) continue;  // i begins a run of inside corners
        std::size_t last = i;
        while (is_inside(last + 1)) ++last;
        const int entry = edge_between(face[(i + 3) % 4], face[i]);
        const int exit = edge_between(face[last % 4], face[(last + 1) % 4]);
        next[static_cast<std::size_t>(entry)] = exit;
      }
    }
  }
  return next;
}

using Triangles = std::vector<std::array<std::uint8_t, 3>>;

// Cuts the polygon into triangles with admissible inner edges only; false when there is no such way.
bool triangulate(std::span<const int> polygon, Triangles& out) {
  const std::size_t n = polygon.size();
  if (n < 3) return true;
  for (std::size_t k = 1; k + 1 < n; ++k) {
    if (k > 1 && share_a_face(polygon[0], polygon[k])) continue;
    if (k + 2 < n && share_a_face(polygon[k], polygon[n - 1])) continue;
    const std::size_t before = out.size();
    out.push_back({static_cast<std::uint8_t>(polygon[0]), static_cast<std::uint8_t>(polygon[k]),
                   static_cast<std::uint8_t>(polygon[n - 1])});
    if (triangulate(polygon.first(k + 1), out) && triangulate(polygon.subspan(k), out)) return true;
    out.resize(before);
  }
  return false;
}

}  // namespace

CubeEdge cube_edge(int edge) {
  CubeEdge e{edge / 4, {}, {}};
  int bits = edge % 4;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == e.axis) continue;
    e.from[static_cast<std::size_t>(axis)] = bits & 1;
    bits >>= 1;
  }
  std::array<int, 3> to = e.from;
  to[static_cast<std::size_t>(e.axis)] = 1;
  e.corners = {corner_at(e.from), corner_at(to)};
  return e;
}

CubeCases make_cube_cases() {
  CubeCases cases;
  for (int inside = 0; inside < 256; ++inside) {
    std::array<int, 12> next = outlines(inside);
    for (std::size_t start = 0; start < 12; ++start) {
      std::vector<int> polygon;
      for (int e = static_cast<int>(start); next[static_cast<std::size_t>(e)] >= 0;) {
        polygon.push_back(e);
        e = std::exchange(next[static_cast<std::size_t>(e)], -1);
      }
      const bool possible = triangulate(polygon, cases[static_cast<std::size_t>(inside)]);
      FLOATSTAGE_CHECK(possible, text("marching-cubes case ", inside, " has no admissible triangulation"));
    }
  }
  return cases;
}

}  // namespace floatstage::recon
