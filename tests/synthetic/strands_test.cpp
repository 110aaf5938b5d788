#include "core/synthetic/strands.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include <gtest/gtest.h>

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Prism = std::array<Vector3f, kStrandVertices>;

const Choreography kDance = choreography(7);

Prism placed(const Strand& strand, double seconds) {
  Prism vertices;
  place_strand(strand, strand_trail([](double t) { return pose_at(kDance, {}, t); }, seconds), seconds,
               vertices.data());
  return vertices;
}

Vector3f node(const Prism& p, int k) {
  const std::size_t i = static_cast<std::size_t>(k * kStrandSides);
  return (p[i] + p[i + 1] + p[i + 2]) / 3;
}

TEST(Strands, AreTwoToThreeMillimetresWide) {
  for (const Strand& strand : loose_strands(7)) {
    EXPECT_GE(2 * strand.radius, 0.0018);
    EXPECT_LE(2 * strand.radius, 0.0030);
    const Prism prism = placed(strand, 0.3);
    for (int k = 0; k + 1 < kStrandNodes; ++k)
      for (int side = 0; side < kStrandSides; ++side)
        ASSERT_NEAR((prism[static_cast<std::size_t>(k * kStrandSides + side)] - node(prism, k)).norm(),
                    strand.radius, 1e-5);
  }
}

TEST(Strands, BeginAtTheirRootsAndReachNoFurtherThanTheirLength) {
  for (double t : {0.0, 0.7}) {
    const SkeletonPose pose = pose_at(kDance, {}, t);
    for (const Strand& strand : loose_strands(7)) {
      const Prism prism = placed(strand, t);
      EXPECT_LT((node(prism, 0).cast<double>() - pose[strand.bone] * strand.root).norm(), 1e-5);
      EXPECT_LT((node(prism, kStrandNodes - 1) - node(prism, 0)).norm(), strand.length + 0.25)
          << "a trailing strand is torn";
    }
  }
}

TEST(Strands, HangDownAndTrailBehind) {
  const Strand ribbon{.bone = Bone::ForearmRight,
                      .root = {0.03, 0, 0.2},
                      .direction = {1, 0, 0},
                      .length = 0.3,
                      .limpness = 3};
  const Prism prism = placed(ribbon, 0.4);
  const Vector3f end = node(prism, kStrandNodes - 1) - node(prism, kStrandNodes - 2);
  EXPECT_LT(end.normalized().z(), -0.5f);
  // The end follows where the wrist was some frames ago.
  const Strand still{.bone = Bone::Pelvis, .root = {0, 0, 0}, .length = 0.3};
  EXPECT_FALSE(placed(still, 0.1) == placed(still, 0.2));
}

TEST(Strands, AreTubesTurnedOutwards) {
  const std::vector<std::uint32_t> triangles = strand_triangles();
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> half_edges;
  for (std::size_t t = 0; t < triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) ++half_edges[{triangles[t + k], triangles[t + (k + 1) % 3]}];
  int open = 0;
  for (const auto& [edge, count] : half_edges) {
    EXPECT_EQ(count, 1);
    open += !half_edges.contains({edge.second, edge.first});
  }
  EXPECT_EQ(open, 2 * kStrandSides) << "open at both ends only";
  const Prism prism = placed(loose_strands(7).front(), 0);
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Vector3f &a = prism[triangles[t]], &b = prism[triangles[t + 1]], &c = prism[triangles[t + 2]];
    const int k = static_cast<int>(triangles[t]) / kStrandSides;
    const Vector3f axis = (node(prism, k) + node(prism, std::min(k + 1, kStrandNodes - 1))) / 2;
    EXPECT_GT((b - a).cross(c - a).dot((a + b + c) / 3 - axis), 0) << t;
  }
}

TEST(Strands, GrowFromTheSeed) {
  const auto a = loose_strands(1), b = loose_strands(2), c = loose_strands(1);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_GT(a.size(), 100u);
  EXPECT_NE(a[0].root, b[0].root);
  EXPECT_EQ(a[0].root, c[0].root);
}

}  // namespace
}  // namespace floatstage::synthetic
