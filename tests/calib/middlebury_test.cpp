#include "calib/formats/parsers.h"
#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

// The second camera stands at (0, 0, -2) and looks along +z; the first is turned by 90° about its axis.
const std::string kTwoMiddleburyCameras =
    "2\n"
    "a.png 3 0 0.5 0 4 0.5 0 0 1 0 1 0 -1 0 0 0 0 1 0.1 0.2 0.3\n"
    "b.png 3 0 0.5 0 3 0.5 0 0 1 1 0 0 0 1 0 0 0 1 0 0 2\n";

Result<ForeignRig> middlebury(std::string_view content) { return parse_middlebury(content, "x_par.txt"); }

TEST(Middlebury, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = middlebury(kTwoMiddleburyCameras);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
  EXPECT_EQ(m.fx, 3.0);
  EXPECT_EQ(m.fy, 4.0);
}

TEST(Middlebury, ReadsRotationAndTranslationAsCameraFromWorld) {
  const Result<ForeignRig> rig = middlebury(kTwoMiddleburyCameras);
  ASSERT_TRUE(rig.has_value());
  EXPECT_TRUE((rig->rig.cameras[1].cam_from_world.center()).isApprox(Eigen::Vector3d(0, 0, -2)));
  const Eigen::Vector3d x = rig->rig.cameras[0].cam_from_world * Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d(2.1, -0.8, 3.3))) << x;
}

TEST(Middlebury, NamesCamerasAfterTheirImagesAndLeavesSizesUnstated) {
  const Result<ForeignRig> rig = middlebury(kTwoMiddleburyCameras);
  ASSERT_TRUE(rig.has_value());
  EXPECT_THAT(rig->image_names, testing::ElementsAre("a.png", "b.png"));
  EXPECT_EQ(rig->rig.cameras[1].serial, "b");
  EXPECT_EQ(rig->rig.cameras[1].model.width, 0);
  EXPECT_EQ(rig->rig.cameras[1].model.height, 0);
}

TEST(Middlebury, RefusesEveryTruncation) { expect_truncations_refused(kTwoMiddleburyCameras, 2, middlebury); }

TEST(Middlebury, SaysWhichLineAndCameraIsWrong) {
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "0.2 0.3", "0.2 nan")), ErrorCode::BadData,
               {"x_par.txt: line 2", "a.png", "nan"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "0 0 2\n", "0 0 inf\n")), ErrorCode::BadData,
               {"line 3", "b.png", "inf"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "0.1 0.2", "0.1")), ErrorCode::BadData,
               {"line 2", "22 words", "21"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "b.png 3", "b.png -3")), ErrorCode::BadData,
               {"line 3", "focal"});
}

TEST(Middlebury, RefusesACountThatTheFileDoesNotKeep) {
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "2\n", "3\n")), ErrorCode::BadData,
               {"camera 3 of 3", "cut off"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "2\n", "1\n")), ErrorCode::BadData,
               {"line 3", "more cameras"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "2\n", "-2\n")), ErrorCode::BadData, {"line 1"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "2\n", "99999999999\n")), ErrorCode::BadData,
               {"line 1"});
}

TEST(Middlebury, RefusesMirrorsAndScaledRotations) {
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "0 1 0 -1 0 0", "0 1 0 1 0 0")), ErrorCode::BadData,
               {"line 2", "mirror"});
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "0 1 0 -1 0 0", "0 1.01 0 -1 0 0")),
               ErrorCode::BadData, {"orthonormal"});
}

TEST(Middlebury, RefusesTwoCamerasOfOneName) {
  expect_error(middlebury(replaced(kTwoMiddleburyCameras, "b.png", "a.png")), ErrorCode::BadData,
               {"x_par.txt", "two cameras", "'a'"});
}

TEST(Middlebury, ComesBackFromTheWriterUnchanged) {
  TempFolder folder;
  Rig rig = sample_rig(std::monostate{});
  rig.cameras[1].model.skew = 0.25;
  ASSERT_TRUE(write_middlebury(rig, {"cam0", "cam1", "cam2"}, folder / "r_par.txt").has_value());
  const Result<ForeignRig> again = read_middlebury(folder / "r_par.txt");
  ASSERT_TRUE(again.has_value()) << again.error().message;
  expect_same(rig, again->rig);
}

TEST(Middlebury, WriterRefusesALensAndLeavesNoFile) {
  TempFolder folder;
  expect_error(write_middlebury(sample_rig(BrownConrady{.k1 = 0.1}), {"a", "b", "c"}, folder / "r_par.txt"),
               ErrorCode::Unsupported, {"r_par.txt", "cam0", "distortion"});
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

TEST(Middlebury, MissingFileIsNotFound) {
  TempFolder folder;
  expect_error(read_middlebury(folder / "none_par.txt"), ErrorCode::NotFound, {"none_par.txt"});
}

}  // namespace
}  // namespace floatstage::calib
