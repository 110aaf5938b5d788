#include "core/mesh.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace floatstage {
namespace {

// A corner of a cube with edges of 2 m, moved away from the origin.
Mesh tetrahedron() {
  return {{{10, 5, 1}, {12, 5, 1}, {10, 7, 1}, {10, 5, 3}}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
}

TEST(SignedVolume, OfATetrahedronIsASixthOfItsBoxWhereverItStands) {
  EXPECT_NEAR(signed_volume(tetrahedron()), 8.0 / 6, 1e-9);
}

TEST(SignedVolume, IsNegativeWhenTheMeshIsInsideOut) {
  Mesh mesh = tetrahedron();
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  EXPECT_NEAR(signed_volume(mesh), -8.0 / 6, 1e-9);
}

TEST(SignedVolume, OfNothingIsNothing) { EXPECT_EQ(signed_volume(Mesh{}), 0); }

TEST(BoundingBox, TouchesTheOutermostVertices) {
  const Eigen::AlignedBox3f box = bounding_box(tetrahedron());
  EXPECT_EQ(box.min(), Eigen::Vector3f(10, 5, 1));
  EXPECT_EQ(box.max(), Eigen::Vector3f(12, 7, 3));
}

TEST(BoundingBox, OfNothingIsEmpty) { EXPECT_TRUE(bounding_box(Mesh{}).isEmpty()); }

TEST(Mesh, CountsTriangles) {
  EXPECT_EQ(tetrahedron().triangle_count(), 4u);
  EXPECT_TRUE(Mesh{}.empty());
}

}  // namespace
}  // namespace floatstage
