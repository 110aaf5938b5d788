#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"

namespace floatstage::calib {
namespace {

// One camera 2 m up and 4 m along -y that looks along +y, level; its picture is a 2×2 part of the sensor that
// begins at column 10 and row 20, with the principal point at its exact centre.
const std::string kLevel =
    "<?xml version=\"1.0\"?>\n"
    "<calibration>\n"
    " <cameras>\n"
    "  <camera active=\"1\" serial=\"A1\">\n"
    "   <fov_video left=\"10\" top=\"20\" right=\"11\" bottom=\"21\"/>\n"
    "   <transform x=\"0\" y=\"-4000\" z=\"2000\" r11=\"1\" r12=\"0\" r13=\"0\" r21=\"0\" r22=\"0\" "
    "r23=\"1\" r31=\"0\" r32=\"-1\" r33=\"0\"/>\n"
    "   <intrinsic focalLengthU=\"192\" focalLengthV=\"256\" centerPointU=\"672\" centerPointV=\"1312\" "
    "skew=\"0\""
    " radialDistortion1=\"-0.04\" radialDistortion2=\"0.1\" radialDistortion3=\"0.01\" "
    "tangentalDistortion1=\"0.001\" tangentalDistortion2=\"0.002\"/>\n"
    "  </camera>\n"
    " </cameras>\n"
    "</calibration>\n";

Result<ForeignRig> qualisys(std::string_view xml) { return parse_qualisys(xml, "Calib.qca.txt"); }

TEST(Qualisys, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = qualisys(kLevel);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.width, 2);
  EXPECT_EQ(m.height, 2);
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
}

TEST(Qualisys, ReadsLengthsOnTheSensorInSixtyFourthsOfAPixel) {
  const Result<ForeignRig> rig = qualisys(kLevel);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.fx, 3.0);
  EXPECT_EQ(rig->rig.cameras[0].model.fy, 4.0);
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(BrownConrady{-0.04, 0.1, 0.001, 0.002, 0.01}));
}

TEST(Qualisys, ReadsAxesOfYUpAndZBackwardsAndMillimetres) {
  const Result<ForeignRig> rig = qualisys(kLevel);
  ASSERT_TRUE(rig.has_value());
  const Rigid3& t = rig->rig.cameras[0].cam_from_world;
  EXPECT_TRUE(t.center().isApprox(Eigen::Vector3d(0, -4, 2)));
  // A point 1 m ahead, 0.2 m to the right and 0.1 m higher: right, up (negative) and forward in our axes.
  const Eigen::Vector3d x = t * Eigen::Vector3d(0.2, -3, 2.1);
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d(0.2, -0.1, 1))) << x;
}

TEST(Qualisys, PassesOverInactiveCameras) {
  const std::string off = replaced(kLevel, "active=\"1\"", "active=\"0\"");
  expect_error(qualisys(off), ErrorCode::BadData, {"no active"});
}

TEST(Qualisys, LeavesTheSizeOpenWithoutAFieldOfView) {
  const Result<ForeignRig> rig = qualisys(replaced(kLevel, "<fov_video", "<fov_other"));
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.width, 0);
}

TEST(Qualisys, SaysWhichLineAndCameraIsWrong) {
  expect_error(qualisys(replaced(kLevel, "x=\"0\"", "x=\"nan\"")), ErrorCode::BadData,
               {"Calib.qca.txt: line 6", "A1", "nan"});
  expect_error(qualisys(replaced(kLevel, "focalLengthU", "focal")), ErrorCode::BadData,
               {"line 7", "focalLengthU", "missing"});
  expect_error(qualisys(replaced(kLevel, "r11=\"1\"", "r11=\"-1\"")), ErrorCode::BadData,
               {"line 6", "mirror"});
  expect_error(qualisys(replaced(kLevel, "r11=\"1\"", "r11=\"0.9\"")), ErrorCode::BadData,
               {"line 6", "orthonormal"});
  expect_error(qualisys(replaced(kLevel, "<transform", "<other")), ErrorCode::BadData,
               {"line 4", "<transform> is missing"});
  expect_error(qualisys(replaced(kLevel, "right=\"11\"", "right=\"9\"")), ErrorCode::BadData,
               {"line 5", "fov_video"});
  expect_error(qualisys("<calibration/>"), ErrorCode::BadData, {"Calib.qca.txt", "no active"});
}

TEST(Qualisys, RefusesEveryTruncation) { expect_truncations_refused(kLevel, 1, qualisys); }

}  // namespace
}  // namespace floatstage::calib
