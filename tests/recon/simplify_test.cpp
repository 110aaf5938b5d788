#include "recon/mesh/simplify.h"

#include <cmath>
#include <numbers>
#include <set>

#include "recon/mesh/mesh_check.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

// A ball of radius 1, closed; without its last rows where `open`.
Mesh ball(int rings, bool open = false) {
  Mesh mesh;
  const int around = 2 * rings;
  mesh.positions.emplace_back(0, 0, 1);
  for (int r = 1; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * a / around;
      mesh.positions.push_back(
          Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))
              .cast<float>());
    }
  mesh.positions.emplace_back(0, 0, -1);
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  auto at = [&](int r, int a) { return static_cast<std::uint32_t>(1 + (r - 1) * around + a % around); };
  for (int a = 0; a < around; ++a) {
    mesh.triangles.insert(mesh.triangles.end(), {0, at(1, a), at(1, a + 1)});
    for (int r = 1; r < rings - 1; ++r)
      mesh.triangles.insert(mesh.triangles.end(), {at(r, a), at(r + 1, a), at(r, a + 1), at(r, a + 1),
                                                   at(r + 1, a), at(r + 1, a + 1)});
    if (!open) mesh.triangles.insert(mesh.triangles.end(), {at(rings - 1, a), last, at(rings - 1, a + 1)});
  }
  return mesh;
}

TEST(Simplified, KeepsABallABallOfFewerTriangles) {
  const Mesh mesh = ball(24);
  const Result<Mesh> small = simplified(mesh, 300);
  ASSERT_THAT(small, IsOk());
  EXPECT_LE(small->triangle_count(), 300u);
  EXPECT_GT(small->triangle_count(), 250u);
  const MeshCheck check = check_mesh(*small);
  EXPECT_TRUE(check.good()) << check.summary();
  EXPECT_GT(check.volume, 0.93 * signed_volume(mesh));
  for (const Eigen::Vector3f& p : small->positions) EXPECT_NEAR(p.norm(), 1, 1e-5) << "a vertex of the input";
}

TEST(Simplified, LeavesHolesAndWhatIsSmallEnough) {
  const Mesh open = ball(16, true);
  const Result<Mesh> small = simplified(open, 100);
  ASSERT_THAT(small, IsOk());
  EXPECT_LE(small->triangle_count(), 100u);
  EXPECT_FALSE(check_mesh(*small).watertight);
  const Result<Mesh> same = simplified(open, 100000);
  ASSERT_THAT(same, IsOk());
  EXPECT_EQ(same->triangles, open.triangles);
}

TEST(Simplified, GivesTheSameBytesTwice) {
  const Result<Mesh> one = simplified(ball(20), 200), two = simplified(ball(20), 200);
  ASSERT_THAT(one, IsOk());
  EXPECT_EQ(one->triangles, two->triangles);
  EXPECT_EQ(one->positions, two->positions);
}

TEST(Simplified, RefusesWhatHasNoNeighbours) {
  Mesh fan;
  fan.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  fan.triangles = {0, 1, 2, 0, 1, 3, 0, 1, 4};
  EXPECT_THAT(simplified(fan, 2), FailsWith(ErrorCode::BadData, "third at an edge"));
  EXPECT_THAT(simplified(fan, 0), FailsWith(ErrorCode::InvalidArgument, "0 triangles"));
}

}  // namespace
}  // namespace floatstage::recon
