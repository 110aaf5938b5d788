#include "recon/mesh/mesh_silhouettes.h"

#include <gtest/gtest.h>

#include "recon/mesh/mesh_mask.h"
#include "recon/visual_hull.h"
#include "tests/recon/bodies.h"
#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

RigCamera camera_of(double focal) {
  RigCamera camera;
  camera.serial = "c";
  camera.model = {
      .width = 64, .height = 48, .fx = focal, .fy = focal, .cx = 32, .cy = 24, .skew = 0, .lens = {}};
  return camera;
}

int pixels_that_differ(const Matte& a, const Matte& b) {
  int differ = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) differ += a.row(y)[x] != b.row(y)[x];
  return differ;
}

void expect_those_of_mesh_mask(const Mesh& mesh, const Rig& rig) {
  const MeshSilhouettes silhouettes(mesh);
  for (const RigCamera& camera : rig.cameras) {
    const Matte mask = mesh_mask(camera, mesh);
    EXPECT_EQ(pixels_that_differ(silhouettes.of(camera), mask), 0) << camera.serial;
    EXPECT_GT(coverage(mask), 0);
  }
}

TEST(MeshSilhouettes, AreMeshMasksThroughEveryLens) {
  for (const Lens& lens :
       {Lens{}, Lens{BrownConrady{-0.2, 0.05, 1e-3, 0, 0}}, Lens{KannalaBrandt{0.02, 0, 0, 0}}})
    expect_those_of_mesh_mask(torus_mesh(0.5f, 0.2f, 96, 48),
                              shapes::ring_rig({.cameras = 5, .distance = 1.8, .focal = 120, .lens = lens}));
}

TEST(MeshSilhouettes, OfBodiesBesideAndBehindOneAnotherAreTheirUnion) {
  Mesh mesh = torus_mesh(0.5f, 0.2f);
  append(mesh, cube({0.1f, 0.05f, 0.02f}, 0.31f));                     // in the hole
  append(mesh, cube({0.43f, 0.21f, 0.33f}, 0.27f));                    // crosses the ring
  append(mesh, turned_inside_out(cube({0.1f, 0.05f, 0.02f}, 0.11f)));  // a cavity
  expect_those_of_mesh_mask(mesh, shapes::ring_rig({.cameras = 7, .distance = 1.9, .focal = 131}));
}

TEST(MeshSilhouettes, OfAHullOfSliversAreMeshMasks) {
  const Rig rig = shapes::ring_rig({.cameras = 14, .distance = 1.8, .focal = 120});
  const Result<HullReport> hull =
      visual_hull(rig, shapes::render_mattes(rig, shapes::torus({0, 0, 0}, 0.5, 0.2)), {});
  ASSERT_TRUE(hull);
  ASSERT_GT(hull->mesh.triangle_count(), 1000u);
  expect_those_of_mesh_mask(hull->mesh, shapes::ring_rig({.cameras = 4, .distance = 2.1, .focal = 317}));
}

TEST(MeshSilhouettes, OfAnEdgeThatFourTrianglesShareAreMeshMasks) {
  // Two cubes that touch along one edge, by the same vertices.
  Mesh mesh = cube({0, 0, 0}, 0.4f), other = cube({0.4f, 0.4f, 0}, 0.4f);
  const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
  append(mesh, other);
  for (std::uint32_t& v : mesh.triangles) {
    if (v == first) v = 3;      // at (0.2, 0.2, -0.2)
    if (v == first + 4) v = 7;  // above it
  }
  expect_those_of_mesh_mask(mesh, shapes::ring_rig({.cameras = 6, .distance = 1.9, .focal = 133}));
}

TEST(MeshSilhouettes, OfAnOpenMeshAreWhatItsTrianglesCover) {
  Mesh mesh = torus_mesh(0.5f, 0.2f);
  mesh.triangles.resize(mesh.triangles.size() / 2);
  expect_those_of_mesh_mask(mesh, shapes::ring_rig({.cameras = 3, .distance = 1.8, .focal = 120}));
}

TEST(MeshSilhouettes, AreCutOffBehindTheCamera) {
  const RigCamera camera = camera_of(50);
  EXPECT_EQ(coverage(MeshSilhouettes(cube({0, 0, -3}, 1)).of(camera)), 0) << "all of it behind";
  EXPECT_EQ(coverage(MeshSilhouettes(cube({0, 0, 0}, 4)).of(camera)), 1) << "all around the camera";
  EXPECT_NEAR(coverage(MeshSilhouettes(cube({0, 50, 0}, 100)).of(camera)), 0.5, 0.02)
      << "a floor at the camera's height";
}

TEST(MeshSilhouettes, EndAtThePicturesBorders) {
  const RigCamera camera = camera_of(100);
  for (const Eigen::Vector3f& at :
       {Eigen::Vector3f(-0.7f, 0, 2), {0.7f, 0, 2}, {0, -0.5f, 2}, {0, 0.5f, 2}, {9, 9, 2}, {0, 0, 2}}) {
    const Mesh mesh = cube(at, 0.613f);
    EXPECT_EQ(pixels_that_differ(MeshSilhouettes(mesh).of(camera), mesh_mask(camera, mesh)), 0)
        << at.transpose();
  }
}

TEST(MeshSilhouettes, OfNothingAreEmpty) {
  const RigCamera camera = shapes::ring_rig({.cameras = 1}).cameras[0];
  EXPECT_TRUE(MeshSilhouettes().empty());
  EXPECT_EQ(coverage(MeshSilhouettes(Mesh()).of(camera)), 0);
  EXPECT_EQ(MeshSilhouettes().of(camera).width, camera.model.width);
}

}  // namespace
}  // namespace floatstage::recon
