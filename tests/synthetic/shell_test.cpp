#include "core/synthetic/shell.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "core/mesh.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;

Mesh mesh_of(const Shell& shell) {
  Mesh mesh;
  for (const Vector3d& p : shell.rest) mesh.positions.push_back(p.cast<float>());
  mesh.triangles = shell.triangles;
  return mesh;
}

void expect_closed(const Shell& shell) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> half_edges;
  for (std::size_t t = 0; t < shell.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k)
      ++half_edges[{shell.triangles[t + k], shell.triangles[t + (k + 1) % 3]}];
  for (const auto& [edge, count] : half_edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(half_edges.contains({edge.second, edge.first}));
  }
}

TEST(Blob, OfTheIdentityIsASphere) {
  const Shell sphere = blob(60, 80, [](const Vector3d& u) { return u; });
  expect_closed(sphere);
  for (const Vector3d& p : sphere.rest) EXPECT_NEAR(p.norm(), 1, 1e-12);
  EXPECT_NEAR(signed_volume(mesh_of(sphere)), 4 * std::numbers::pi / 3, 0.02) << "and turned outwards";
}

TEST(Tube, OfTwoEqualSectionsIsACylinderWithRoundedEnds) {
  const Shell cylinder = tube({{0, 0.1, 0.1, 0}, {1, 0.1, 0.1, 0}},
                              {.rings = 10, .segments = 64, .near_cap = 0.1, .far_cap = 0.1});
  expect_closed(cylinder);
  // A cylinder and two half spheres.
  const double volume = std::numbers::pi * 0.01 * (1 + 4.0 / 3 * 0.1);
  EXPECT_NEAR(signed_volume(mesh_of(cylinder)), volume, 0.02 * volume);
  const Eigen::AlignedBox3f box = bounding_box(mesh_of(cylinder));
  EXPECT_NEAR(box.min().z(), -0.1, 1e-6);
  EXPECT_NEAR(box.max().z(), 1.1, 1e-6);
}

TEST(Tube, PassesThroughItsSectionsAndNeverBulgesBetweenThem) {
  const std::vector<Section> sections = {
      {0, 0.10, 0.05, 0}, {0.3, 0.10, 0.05, 0.02}, {0.31, 0.04, 0.03, 0.02}, {0.6, 0.04, 0.03, 0}};
  const Shell sleeve = tube(sections, {.rings = 60, .segments = 16});
  expect_closed(sleeve);
  for (const Section& s : sections) {
    const bool there = std::any_of(sleeve.rest.begin(), sleeve.rest.end(), [&](const Vector3d& p) {
      return (p - Vector3d(s.a, s.y, s.z)).norm() < 1e-9;
    });
    EXPECT_TRUE(there) << "the section at z = " << s.z;
  }
  for (const Vector3d& p : sleeve.rest) {
    EXPECT_LE(std::abs(p.x()), 0.10 + 1e-12);
    if (p.z() > 0.31) {
      EXPECT_LE(std::abs(p.x()), 0.04 + 1e-12) << "the cuff is a step";
    }
  }
}

TEST(Tube, OfAHigherExponentIsSquarer) {
  auto volume = [](double exponent) {
    return signed_volume(
        mesh_of(tube({{0, 1, 1, 0}, {1, 1, 1, 0}}, {.rings = 4, .segments = 128, .exponent = exponent})));
  };
  EXPECT_GT(volume(4), 1.1 * volume(2));
  EXPECT_LT(volume(4), 4.1);
}

TEST(Moved, MovesEveryPointAndKeepsTheTriangles) {
  const Shell sphere = blob(6, 8, [](const Vector3d& u) { return u; });
  const Shell aside = moved(sphere, [](const Vector3d& p) { return Vector3d(p + Vector3d(3, 0, 0)); });
  EXPECT_EQ(aside.triangles, sphere.triangles);
  for (std::size_t i = 0; i < sphere.rest.size(); ++i)
    EXPECT_NEAR((aside.rest[i] - sphere.rest[i]).x(), 3, 1e-12);
}

}  // namespace
}  // namespace floatstage::synthetic
