#include "recon/mesh/mesh_mask.h"

#include <gtest/gtest.h>

#include "tests/recon/bodies.h"
#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

TEST(MeshMask, CoversTheSquareOfKnownPixels) {
  // A cube face at z = 2 of side 0.4 under a focal length of 100: 20 pixels wide, centred on (32, 24).
  RigCamera camera;
  camera.serial = "c";
  camera.model = {.width = 64, .height = 48, .fx = 100, .fy = 100, .cx = 32, .cy = 24, .skew = 0, .lens = {}};
  const Matte mask = mesh_mask(camera, cube({0, 0, 2.2f}, 0.4f));
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      EXPECT_EQ(mask.row(y)[x] == 255, x >= 22 && x < 42 && y >= 14 && y < 34) << x << ", " << y;
}

TEST(MeshMask, AgreesWithRaysThroughEveryLens) {
  for (const Lens& lens :
       {Lens{}, Lens{BrownConrady{-0.2, 0.05, 1e-3, 0, 0}}, Lens{KannalaBrandt{0.02, 0, 0, 0}}}) {
    const Rig rig = shapes::ring_rig({.cameras = 3, .distance = 1.8, .focal = 120, .lens = lens});
    const Mesh mesh = torus_mesh(0.5f, 0.2f, 96, 48);
    for (const RigCamera& camera : rig.cameras)
      EXPECT_GT(
          iou(mesh_mask(camera, mesh), shapes::render_matte(camera, shapes::torus({0, 0, 0}, 0.5, 0.2))),
          0.985);
  }
}

TEST(MeshMask, CutsOffWhatIsBehindTheCamera) {
  RigCamera camera;
  camera.serial = "c";
  camera.model = {.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24, .skew = 0, .lens = {}};
  EXPECT_EQ(coverage(mesh_mask(camera, cube({0, 0, -3}, 1))), 0) << "all of it behind";
  EXPECT_EQ(coverage(mesh_mask(camera, cube({0, 0, 0}, 4))), 1) << "all around the camera";
  EXPECT_NEAR(coverage(mesh_mask(camera, cube({0, 50, 0}, 100))), 0.5, 0.02)
      << "a floor at the camera's height";
}

TEST(MeshMask, TakesTrianglesThatReachFurtherToTheSideThanIntegersDo) {
  // Found by fuzzing. Cut off just before the camera, it crosses the picture's upper rows billions of pixels
  // away.
  RigCamera camera;
  camera.serial = "c";
  camera.model = {.width = 64, .height = 48, .fx = 500, .fy = 500, .cx = 32, .cy = 24, .skew = 0, .lens = {}};
  Mesh mesh;
  mesh.positions = {{-0.1f, -0.5f, 1}, {0.1f, 0.5f, 1}, {1e7f, 0, -1}};
  mesh.triangles = {0, 1, 2};
  const Matte right = mesh_mask(camera, mesh);
  for (Eigen::Vector3f& p : mesh.positions) p.x() = -p.x();
  const Matte left = mesh_mask(camera, mesh);
  for (int y = 0; y < 48; ++y) {
    for (int x : {2, 60})
      EXPECT_EQ(right.row(y)[x] + left.row(y)[x], 255) << x << ", " << y << ": one on each side";
  }
}

TEST(MeshMask, OfNothingIsEmpty) {
  const RigCamera camera = shapes::ring_rig({.cameras = 1}).cameras[0];
  const Matte mask = mesh_mask(camera, {});
  EXPECT_EQ(mask.width, camera.model.width);
  EXPECT_EQ(coverage(mask), 0);
}

}  // namespace
}  // namespace floatstage::recon
