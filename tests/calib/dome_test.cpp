#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"

namespace floatstage::calib {
namespace {

const std::string kTwoDomeCameras =
    "0\n3\t0.25\t0.5\n0.0\t4\t0.5\n0.0\t0.0\t1.0\n-0.04\t0.1\n"
    "1\t0\t0\t0\n0\t1\t0\t0\n0\t0\t1\t0\n"
    "\n"
    "1\n3\t0\t0.5\n0.0\t3\t0.5\n0.0\t0.0\t1.0\n0\t0\n"
    "0\t1\t0\t10\n-1\t0\t0\t20\n0\t0\t1\t30\n";

Result<ForeignRig> dome(std::string_view content) { return parse_dome(content, 0.1, "calibration.txt"); }

TEST(Dome, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = dome(kTwoDomeCameras);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
  EXPECT_EQ(m.skew, 0.25);
  EXPECT_EQ(m.fy, 4.0);
}

TEST(Dome, NamesCamerasByTwoDigits) {
  const Result<ForeignRig> rig = dome(replaced(kTwoDomeCameras, "\n\n1\n", "\n\n12\n"));
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].serial, "00");
  EXPECT_EQ(rig->rig.cameras[1].serial, "12");
}

TEST(Dome, ReadsRadialDistortionAndNoneWhereItIsZero) {
  const Result<ForeignRig> rig = dome(kTwoDomeCameras);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(BrownConrady{.k1 = -0.04, .k2 = 0.1}));
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens(std::monostate{}));
}

TEST(Dome, ScalesTranslationsToMetres) {
  const Result<ForeignRig> tenth = dome(kTwoDomeCameras);
  const Result<ForeignRig> half = parse_dome(kTwoDomeCameras, 0.5, "calibration.txt");
  ASSERT_TRUE(tenth.has_value() && half.has_value());
  EXPECT_TRUE(tenth->rig.cameras[1].cam_from_world.translation.isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(half->rig.cameras[1].cam_from_world.translation.isApprox(Eigen::Vector3d(5, 10, 15)));
}

TEST(Dome, RefusesAScaleThatIsNoLength) {
  for (double scale :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    expect_error(parse_dome(kTwoDomeCameras, scale, "c"), ErrorCode::InvalidArgument, {"metres per unit"});
}

TEST(Dome, RefusesEveryTruncation) { expect_truncations_refused(kTwoDomeCameras, 2, dome); }

TEST(Dome, SaysWhichLineAndCameraIsWrong) {
  expect_error(dome(replaced(kTwoDomeCameras, "-0.04", "nan")), ErrorCode::BadData,
               {"calibration.txt: line 5", "'00'", "nan"});
  expect_error(dome(replaced(kTwoDomeCameras, "\t10\n", "\n")), ErrorCode::BadData,
               {"line 15", "R|t", "'01'", "4 numbers"});
  expect_error(dome(replaced(kTwoDomeCameras, "0.0\t0.0\t1.0", "0.0\t0.1\t1.0")), ErrorCode::BadData,
               {"line 4", "K"});
  expect_error(dome(replaced(kTwoDomeCameras, "-1\t0\t0\t20", "1\t0\t0\t20")), ErrorCode::BadData,
               {"line 17", "mirror"});
  expect_error(dome(replaced(kTwoDomeCameras, "\n\n1\n", "\n\nx\n")), ErrorCode::BadData,
               {"line 10", "index"});
  expect_error(dome(replaced(kTwoDomeCameras, "\n\n1\n", "\n\n0\n")), ErrorCode::BadData,
               {"two cameras", "00"});
}

TEST(Dome, ReadsWindowsLineEndsAlike) {
  std::string windows;
  for (char c : kTwoDomeCameras) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Result<ForeignRig> unix_rig = dome(kTwoDomeCameras), windows_rig = dome(windows);
  ASSERT_TRUE(unix_rig.has_value() && windows_rig.has_value());
  expect_same(unix_rig->rig, windows_rig->rig, 1e-300);
}

}  // namespace
}  // namespace floatstage::calib
