#include "recon/octree/octree_cases.h"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>

namespace floatstage::recon {
namespace {

using Line = std::pair<int, int>;

bool on_face(int edge, int axis, int side) {
  const CubeEdge e = cube_edge(edge);
  return e.axis != axis && e.from[static_cast<std::size_t>(axis)] == side;
}

// The four signs of a case on one face of its cell.
int signs_on_face(int inside, int axis, int side) {
  int signs = 0, at = 0;
  for (int corner = 0; corner < 8; ++corner)
    if (((corner >> axis) & 1) == side) signs |= ((inside >> corner) & 1) << at++;
  return signs;
}

// The outline that a case leaves on one face of its cell: directed pairs of cube edges without their reverse.
std::set<Line> outline(const CubeCases& cases, int inside, int axis, int side) {
  std::set<Line> all, open;
  for (const auto& t : cases[static_cast<std::size_t>(inside)])
    for (std::size_t i = 0; i < 3; ++i) all.insert({t[i], t[(i + 1) % 3]});
  for (const auto& [from, to] : all)
    if (!all.contains({to, from}) && on_face(from, axis, side) && on_face(to, axis, side))
      open.insert({from, to});
  return open;
}

// A cube edge of the low face, as the neighbour below knows it.
int across(int edge, int axis) {
  const CubeEdge mine = cube_edge(edge);
  for (int other = 0; other < 12; ++other) {
    const CubeEdge e = cube_edge(other);
    std::array<int, 3> from = mine.from;
    from[static_cast<std::size_t>(axis)] = 1;
    if (e.axis == mine.axis && e.from == from) return other;
  }
  return -1;
}

TEST(CubeCases, CutExactlyTheEdgesWithTwoDifferentEnds) {
  const CubeCases cases = make_cube_cases();
  for (int inside = 0; inside < 256; ++inside) {
    std::set<int> used, expected;
    for (const auto& t : cases[static_cast<std::size_t>(inside)]) used.insert(t.begin(), t.end());
    for (int edge = 0; edge < 12; ++edge) {
      const CubeEdge e = cube_edge(edge);
      if (((inside >> e.corners[0]) & 1) != ((inside >> e.corners[1]) & 1)) expected.insert(edge);
    }
    EXPECT_EQ(used, expected) << "case " << inside;
  }
}

TEST(CubeCases, LeaveTheSameOutlineOnAFaceFromBothSides) {
  const CubeCases cases = make_cube_cases();
  for (int axis = 0; axis < 3; ++axis) {
    std::map<int, std::set<Line>> from_below;
    for (int below = 0; below < 256; ++below) {
      const auto [it, is_new] =
          from_below.try_emplace(signs_on_face(below, axis, 1), outline(cases, below, axis, 1));
      EXPECT_EQ(it->second, outline(cases, below, axis, 1)) << "axis " << axis << " case " << below;
    }
    for (int above = 0; above < 256; ++above) {
      std::set<Line> reversed;
      for (const auto& [from, to] : outline(cases, above, axis, 0))
        reversed.insert({across(to, axis), across(from, axis)});
      EXPECT_EQ(reversed, from_below[signs_on_face(above, axis, 0)]) << "axis " << axis << " case " << above;
    }
  }
}

TEST(CubeCases, HaveNoInnerEdgeOnAFace) {
  const CubeCases cases = make_cube_cases();
  for (int inside = 0; inside < 256; ++inside) {
    std::map<Line, int> count;
    for (const auto& t : cases[static_cast<std::size_t>(inside)])
      for (std::size_t i = 0; i < 3; ++i) ++count[std::minmax<int>(t[i], t[(i + 1) % 3])];
    for (const auto& [edge, times] : count) {
      bool shared_face = false;
      for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
          shared_face |= on_face(edge.first, axis, side) && on_face(edge.second, axis, side);
      EXPECT_EQ(times, shared_face ? 1 : 2) << "case " << inside;
    }
  }
}

}  // namespace
}  // namespace floatstage::recon
