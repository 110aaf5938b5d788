#include "recon/octree/octree_surface.h"

#include <optional>

#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_cleanup.h"
#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

Mesh to_mesh(const Surface& surface) {
  Mesh mesh;
  for (const Eigen::Vector3d& p : surface.positions) mesh.positions.push_back(p.cast<float>());
  for (const auto& t : surface.triangles) mesh.triangles.insert(mesh.triangles.end(), t.begin(), t.end());
  return mesh;
}

// A grid of random bits: every marching-cubes case beside every other.
CarvedGrid random_grid(std::uint64_t seed, int resolution, double density, double depth = 1) {
  CarvedGrid grid({Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, depth, depth)}, resolution);
  Random random(seed);
  for (int z = 1; z + 1 < grid.points().z(); ++z)
    for (int y = 1; y + 1 < grid.points().y(); ++y)
      for (int x = 1; x + 1 < grid.points().x(); ++x)
        if (random.uniform() < density) grid.row(y, z)[x >> 6] |= std::uint64_t{1} << (x & 63);
  return grid;
}

TEST(ExtractSurface, IsAClosedOrientedManifoldForAnyArrangementOfSigns) {
  for (const double density : {0.1, 0.5, 0.9}) {
    const CarvedGrid grid = random_grid(1, 16, density);
    const MeshCheck check = check_mesh(to_mesh(extract_surface(grid, {}, 1)));
    EXPECT_TRUE(check.watertight && check.manifold && check.oriented && check.outward) << check.summary();
    EXPECT_EQ(check.degenerate, 0);
    EXPECT_GT(check.volume, 0);
  }
}

TEST(ExtractSurface, ReachesAcrossTheWordsOfARow) {
  const CarvedGrid grid = random_grid(4, 140, 0.3, 0.05);
  const MeshCheck check = check_mesh(to_mesh(extract_surface(grid, {}, 2)));
  EXPECT_TRUE(check.watertight && check.manifold && check.oriented) << check.summary();
}

TEST(ExtractSurface, IsEmptyForAnEmptyGrid) {
  const CarvedGrid grid({Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1)}, 16);
  EXPECT_TRUE(extract_surface(grid, {}, 1).triangles.empty());
}

class RoundBody : public testing::Test {
 protected:
  RoundBody() {
    const Rig rig = shapes::ring_rig({.cameras = 6});
    for (const RigCamera& c : rig.cameras)
      views.emplace_back(c, shapes::render_matte(c, shapes::sphere({0, 0, 0}, 0.5)));
    grid.emplace(carve(views, {Eigen::Vector3d(-0.8, -0.8, -0.8), Eigen::Vector3d(0.8, 0.8, 0.8)}, 40, 1));
    surface = extract_surface(*grid, views, 1);
  }
  std::vector<OctreeView> views;
  std::optional<CarvedGrid> grid;
  Surface surface;
};

TEST_F(RoundBody, HasItsVerticesWhereTheGridEdgesLeaveTheHull) {
  ASSERT_GT(surface.positions.size(), 1000u);
  int on_the_hull = 0;
  for (const Eigen::Vector3d& p : surface.positions) {
    // A vertex lies on one grid edge; two thousandths of a voxel to either side of it the answer differs.
    const Eigen::Vector3d at = (p - grid->position(0, 0, 0)) / grid->voxel();
    int axis = 0;
    (at - at.array().round().matrix()).cwiseAbs().maxCoeff(&axis);
    const Eigen::Vector3d step = 0.002 * grid->voxel() * Eigen::Vector3d::Unit(axis);
    on_the_hull += in_hull(views, p - step) != in_hull(views, p + step);
  }
  // All but those kept clear of a grid point.
  EXPECT_GT(on_the_hull, 0.93 * static_cast<double>(surface.positions.size()));
}

Surface wild_surface() {
  const CarvedGrid grid = random_grid(9, 14, 0.3);
  return extract_surface(grid, {}, 1);
}

TEST(ExtractSurface, CrossesItselfNowhereWithAllVerticesInTheirSafePlaces) {
  for (const double density : {0.2, 0.5, 0.7}) {
    Surface surface = extract_surface(random_grid(3, 18, density), {}, 2);
    surface.positions = surface.safe_positions;
    EXPECT_FALSE(check_mesh(to_mesh(surface)).self_intersecting) << "at density " << density;
  }
}

TEST(CleanupFor, KeepsAWildSurfaceAManifold) {
  const Surface raw = wild_surface();
  const MeshCheck before = check_mesh(to_mesh(raw));
  const MeshCheck after =
      check_mesh(to_mesh(clean_up(raw, {.voxel = 1.0 / 14, .largest_move = 0.5, .threads = 1})));
  EXPECT_TRUE(after.watertight && after.manifold && after.oriented) << after.summary();
  EXPECT_FALSE(after.self_intersecting);
  EXPECT_EQ(after.shells, before.shells);
  EXPECT_EQ(after.genus, before.genus);
}

TEST_F(RoundBody, IsCaredForWithoutMovingAVertexFurtherThanAllowed) {
  const double voxel = grid->voxel();
  for (const double largest_move : {0.03, 0.5}) {
    const Surface still = clean_up(surface, {.voxel = voxel, .largest_move = 0, .threads = 1});
    const Surface cleaned = clean_up(surface, {.voxel = voxel, .largest_move = largest_move, .threads = 1});
    ASSERT_EQ(still.positions.size(), cleaned.positions.size());
    double furthest = 0;
    for (std::size_t i = 0; i < still.positions.size(); ++i)
      furthest = std::max(furthest, (still.positions[i] - cleaned.positions[i]).norm());
    EXPECT_LE(furthest, largest_move * voxel + 1e-6) << "but for rounding to float";
    EXPECT_GT(furthest, 0.02 * voxel);
  }
}

}  // namespace
}  // namespace floatstage::recon
