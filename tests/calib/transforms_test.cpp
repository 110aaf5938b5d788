#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// The camera stands at (0.5, -2, 1) and looks along +y: OpenGL's x is the world's x, its y the world's z.
const std::string kMatrix = "[[1,0,0,0.5],[0,0,-1,-2],[0,1,0,1],[0,0,0,1]]";
const std::string kShared =
    R"({"camera_model": "OPENCV", "fl_x": 800, "fl_y": 810, "cx": 322.5, "cy": 241, "w": 640, "h": 480,
        "k1": 0.1, "k2": -0.2, "p1": 0.001, "p2": 0.002,
        "frames": [{"file_path": "./images/left.png", "transform_matrix": )" +
    kMatrix + R"(}, {"file_path": "images/right.png", "fl_x": 900, "transform_matrix": )" + kMatrix + "}]}";

Result<std::pair<int, int>> no_size(const std::string& picture) {
  return fail(ErrorCode::BadData, "no size of " + picture);
}
Result<std::pair<int, int>> square(const std::string&) { return std::pair(800, 800); }

Result<ForeignRig> transforms(std::string_view content) {
  return parse_transforms(content, no_size, "t.json");
}

TEST(Transforms, TurnOpenGlsCamerasIntoOurs) {
  const Result<ForeignRig> rig = transforms(kShared);
  ASSERT_THAT(rig, IsOk());
  const RigCamera& left = rig->rig.cameras[0];
  EXPECT_EQ(left.serial, "left");
  EXPECT_EQ(rig->image_names[0], "images/left.png");
  EXPECT_TRUE(left.cam_from_world.center().isApprox(Eigen::Vector3d(0.5, -2, 1)));
  // A point before it, to the right and above: x/z = 0.1, y/z = -0.05 in our axes.
  const Eigen::Vector3d p = left.cam_from_world * Eigen::Vector3d(0.7, 0, 1.1);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(0.2, -0.1, 2)));
  // OpenCV's formula, written out.
  const double x = 0.1, y = -0.05, r2 = x * x + y * y, radial = 1 + 0.1 * r2 - 0.2 * r2 * r2;
  const double u = 800 * (x * radial + 2 * 0.001 * x * y + 0.002 * (r2 + 2 * x * x)) + 322.5;
  const double v = 810 * (y * radial + 0.001 * (r2 + 2 * y * y) + 2 * 0.002 * x * y) + 241;
  EXPECT_LT((*project(left.model, p) - Eigen::Vector2d(u, v)).norm(), 1e-9);
  EXPECT_EQ(rig->rig.cameras[1].model.fx, 900) << "what a frame says of itself counts more";
}

TEST(Transforms, TakeAnAngleOfViewAndThePicturesSize) {
  const std::string nerf = R"({"camera_angle_x": 0.6911112070083618, "frames":
    [{"file_path": "./train/r_0", "rotation": 0.012, "transform_matrix": )" +
                           kMatrix + "}]}";
  const Result<ForeignRig> rig = parse_transforms(nerf, square, "t.json");
  ASSERT_THAT(rig, IsOk());
  EXPECT_NEAR(rig->rig.cameras[0].model.fx, 1111.111, 1e-2) << "as NeRF's own loader has it";
  EXPECT_EQ(rig->rig.cameras[0].model.fy, rig->rig.cameras[0].model.fx);
  EXPECT_EQ(rig->rig.cameras[0].model.cx, 400);
  expect_error(transforms(nerf), ErrorCode::BadData, {"t.json: frame 0", "no size of train/r_0"});
}

TEST(Transforms, KnowFisheyes) {
  const std::string fisheye = replaced(replaced(kShared, "\"OPENCV\"", "\"OPENCV_FISHEYE\""),
                                       "\"p1\": 0.001, \"p2\": 0.002", "\"k3\": 3, \"k4\": 4");
  const Result<ForeignRig> rig = transforms(fisheye);
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(KannalaBrandt{0.1, -0.2, 3, 4}));
}

TEST(Transforms, SayWhatIsWrong) {
  expect_error(transforms("{"), ErrorCode::BadData, {"t.json"});
  expect_error(transforms("[]"), ErrorCode::BadData, {"t.json"});
  expect_error(transforms(replaced(kShared, "\"OPENCV\"", "\"EQUIRECTANGULAR\"")), ErrorCode::Unsupported,
               {"frame 0", "EQUIRECTANGULAR"});
  expect_error(transforms(replaced(kShared, "\"fl_x\": 800, \"fl_y\": 810", "\"fl_x\": -1")),
               ErrorCode::BadData, {"frame 0", "focal length"});
  expect_error(transforms(replaced(kShared, "640", "640.5")), ErrorCode::BadData, {"frame 0", "whole"});
  expect_error(transforms(replaced(kShared, "[1,0,0,0.5]", "[0,0,0,0.5]")), ErrorCode::BadData, {"frame 0"});
  expect_error(transforms(replaced(kShared, "[1,0,0,0.5]", "[1,0,0.5]")), ErrorCode::BadData,
               {"transform_matrix"});
  expect_error(transforms(replaced(kShared, "[0,0,0,1]", "[0,0,0,2]")), ErrorCode::BadData, {"last row"});
  expect_error(transforms(replaced(kShared, "right", "left")), ErrorCode::BadData, {"left"});
  expect_error(transforms(R"({"frames": []})"), ErrorCode::BadData, {"t.json"});
}

TEST(Transforms, RefuseEveryTruncation) { expect_truncations_refused(kShared, 2, transforms); }

}  // namespace
}  // namespace floatstage::calib
