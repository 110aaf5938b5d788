#include "recon/mesh/mesh_check.h"

#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mesh/crossings.h"
#include "tests/recon/bodies.h"

namespace floatstage::recon {
namespace {

using testing::HasSubstr;

TEST(CheckMesh, FindsNothingWrongWithACube) {
  const MeshCheck check = check_mesh(cube({1, 2, 3}, 2));
  EXPECT_TRUE(check.good()) << check.summary();
  EXPECT_EQ(check.shells, 1);
  EXPECT_EQ(check.genus, 0);
  EXPECT_EQ(check.degenerate, 0);
  EXPECT_NEAR(check.volume, 8, 1e-6);
  EXPECT_THAT(check.summary(), HasSubstr("1 shell of genus 0, closed, manifold and outward"));
}

TEST(CheckMesh, FindsNothingWrongWithNothing) {
  const MeshCheck check = check_mesh({});
  EXPECT_TRUE(check.good()) << check.summary();
  EXPECT_EQ(check.shells, 0);
  EXPECT_EQ(check.volume, 0);
}

TEST(CheckMesh, CountsTheHoleOfATorus) {
  const MeshCheck check = check_mesh(torus_mesh(1, 0.3f));
  EXPECT_TRUE(check.good()) << check.summary();
  EXPECT_EQ(check.genus, 1);
}

TEST(CheckMesh, CountsShellsThatShareNoVertex) {
  Mesh mesh = cube({0, 0, 0}, 1);
  append(mesh, torus_mesh(3, 0.3f));
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.good()) << check.summary();
  EXPECT_EQ(check.shells, 2);
  EXPECT_EQ(check.genus, 1);
}

TEST(CheckMesh, SeesAHole) {
  Mesh mesh = cube({0, 0, 0}, 1);
  mesh.triangles.resize(mesh.triangles.size() - 3);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_FALSE(check.watertight);
  EXPECT_FALSE(check.manifold);
  EXPECT_TRUE(check.oriented) << "the triangles that are there agree";
  EXPECT_FALSE(check.good());
  EXPECT_THAT(check.summary(), HasSubstr("not watertight"));
}

TEST(CheckMesh, SeesOneFlippedTriangle) {
  Mesh mesh = cube({0, 0, 0}, 1);
  std::swap(mesh.triangles[0], mesh.triangles[1]);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.watertight);
  EXPECT_TRUE(check.manifold) << "manifoldness does not depend on orientation";
  EXPECT_FALSE(check.oriented);
  EXPECT_FALSE(check.good());
}

TEST(CheckMesh, SeesABodyTurnedInsideOut) {
  const MeshCheck check = check_mesh(turned_inside_out(cube({0, 0, 0}, 1)));
  EXPECT_TRUE(check.oriented);
  EXPECT_FALSE(check.outward);
  EXPECT_THAT(check.summary(), HasSubstr("facing inwards"));
}

TEST(CheckMesh, SeesTwoBodiesThatShareOneVertex) {
  Mesh mesh = cube({0, 0, 0}, 1);
  append(mesh, cube({1, 1, 1}, 1));
  for (std::uint32_t& v : mesh.triangles)
    if (v == 8) v = 7;  // the near corner of the second is the far corner of the first
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.watertight);
  EXPECT_FALSE(check.manifold);
  EXPECT_FALSE(check.self_intersecting);
  EXPECT_EQ(check.shells, 1);
}

TEST(CheckMesh, SeesAnEdgeWithFourTriangles) {
  Mesh mesh = cube({0, 0, 0}, 1);
  append(mesh, cube({1, 1, 0}, 1));
  for (std::uint32_t& v : mesh.triangles) {
    if (v == 8) v = 3;
    if (v == 12) v = 7;
  }
  const MeshCheck check = check_mesh(mesh);
  EXPECT_FALSE(check.watertight);
  EXPECT_FALSE(check.manifold);
}

TEST(CheckMesh, SeesShellsThatCross) {
  Mesh mesh = cube({0, 0, 0}, 1);
  append(mesh, cube({0.4f, 0.3f, 0.2f}, 1));
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.manifold);
  EXPECT_TRUE(check.self_intersecting);
  EXPECT_FALSE(check.good());
}

TEST(CheckMesh, TellsACavityFromABodyInsideABody) {
  Mesh hollow = cube({0, 0, 0}, 2);
  Mesh filled = hollow;
  append(hollow, turned_inside_out(cube({0, 0, 0}, 1)));
  append(filled, cube({0, 0, 0}, 1));
  EXPECT_TRUE(check_mesh(hollow).good()) << check_mesh(hollow).summary();
  EXPECT_NEAR(check_mesh(hollow).volume, 7, 1e-5);
  EXPECT_FALSE(check_mesh(filled).outward);
}

TEST(CheckMesh, AcceptsABodyInsideACavity) {
  Mesh mesh = cube({0, 0, 0}, 4);
  append(mesh, turned_inside_out(cube({0, 0, 0}, 2)));
  append(mesh, cube({0, 0, 0}, 1));
  EXPECT_TRUE(check_mesh(mesh).good()) << check_mesh(mesh).summary();
}

TEST(CheckMesh, CountsTrianglesWithoutArea) {
  Mesh mesh = cube({0, 0, 0}, 1);
  const std::uint32_t a = mesh.triangles[0], b = mesh.triangles[1];
  mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]) / 2);
  mesh.triangles.insert(mesh.triangles.end(), {a, b, static_cast<std::uint32_t>(mesh.positions.size() - 1)});
  EXPECT_EQ(check_mesh(mesh).degenerate, 1);
}

TEST(CheckMesh, RefusesIndicesBeyondThePositions) {
  Mesh mesh = cube({0, 0, 0}, 1);
  mesh.triangles[5] = 1000;
  EXPECT_FALSE(check_mesh(mesh).watertight);
  EXPECT_FALSE(check_mesh(mesh).good());
}

TEST(CrossingPairs, AgreeWithTryingEveryPair) {
  Random random(7);
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d at(random.uniform(), random.uniform(), random.uniform());
    const double size = i % 50 == 0 ? 2.0 : 0.15;
    std::array<std::uint32_t, 3> t;
    for (std::uint32_t& v : t) {
      v = static_cast<std::uint32_t>(positions.size());
      positions.push_back(at + size * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    }
    triangles.push_back(t);
  }
  auto corners = [&](std::uint32_t i) {
    return std::array{positions[triangles[i][0]], positions[triangles[i][1]], positions[triangles[i][2]]};
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (std::uint32_t j = i + 1; j < triangles.size(); ++j)
      if (triangles_cross(corners(i), corners(j))) expected.push_back({i, j});
  ASSERT_GT(expected.size(), 100u);
  EXPECT_EQ(crossing_pairs(positions, triangles, 1000, 1), expected);
  EXPECT_EQ(crossing_pairs(positions, triangles, 1000, 3), expected);
}

TEST(TrianglesCross, OnlyWhenAnEdgePiercesAnInside) {
  const std::array<Eigen::Vector3d, 3> floor = {Eigen::Vector3d{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const auto wall = [](double low) {
    return std::array<Eigen::Vector3d, 3>{Eigen::Vector3d{1, 1, low}, {1, 1, low + 1}, {1.5, 1, low + 1}};
  };
  EXPECT_TRUE(triangles_cross(floor, wall(-0.5)));
  EXPECT_TRUE(triangles_cross(wall(-0.5), floor));
  EXPECT_FALSE(triangles_cross(floor, wall(0))) << "a corner on a face only touches";
  EXPECT_FALSE(triangles_cross(floor, wall(0.5)));
  EXPECT_FALSE(triangles_cross(floor, floor)) << "coplanar overlap is not crossing";
}

}  // namespace
}  // namespace floatstage::recon
