#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"

namespace floatstage::calib {
namespace {

const std::string kTwoCameras =
    "0\n3\t0.25\t0.5\n0.0\t4\t0.5\n0.0\t0.0\t1.0\n-0.04\t0.1\n"
    "1\t0\t0\t0\n0\t1\t0\t0\n0\t0\t1\t0\n"
    "\n"
    "1\n3\t0\t0.5\n0.0\t3\t0.5\n0.0\t0.0\t1.0\n0\t0\n"
    "0\t1\t0\t10\n-1\t0\t0\t20\n0\t0\t1\t30\n";

Result<ForeignRig> parse(std::string_view content) { return parse_dome(content, 0.1, "calibration.txt"); }

TEST(Dome, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = parse(kTwoCameras);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
  EXPECT_EQ(m.skew, 0.25);
  EXPECT_EQ(m.fy, 4.0);
}

TEST(Dome, NamesCamerasByTwoDigits) {
  const Result<ForeignRig> rig = parse(replaced(kTwoCameras, "\n\n1\n", "\n\n12\n"));
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].serial, "00");
  EXPECT_EQ(rig->rig.cameras[1].serial, "12");
}

TEST(Dome, ReadsRadialDistortionAndNoneWhereItIsZero) {
  const Result<ForeignRig> rig = parse(kTwoCameras);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(BrownConrady{.k1 = -0.04, .k2 = 0.1}));
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens(std::monostate{}));
}

TEST(Dome, ScalesTranslationsToMetres) {
  const Result<ForeignRig> tenth = parse(kTwoCameras);
  const Result<ForeignRig> half = parse_dome(kTwoCameras, 0.5, "calibration.txt");
  ASSERT_TRUE(tenth.has_value() && half.has_value());
  EXPECT_TRUE(tenth->rig.cameras[1].cam_from_world.translation.isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(half->rig.cameras[1].cam_from_world.translation.isApprox(Eigen::Vector3d(5, 10, 15)));
}

TEST(Dome, RefusesAScaleThatIsNoLength) {
  for (double scale :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    expect_error(parse_dome(kTwoCameras, scale, "c"), ErrorCode::InvalidArgument, {"metres per unit"});
}

TEST(Dome, RefusesEveryTruncation) { expect_truncations_refused(kTwoCameras, 2, parse); }

TEST(Dome, SaysWhichLineAndCameraIsWrong) {
  expect_error(parse(replaced(kTwoCameras, "-0.04", "nan")), ErrorCode::BadData,
               {"calibration.txt: line 5", "'00'", "nan"});
  expect_error(parse(replaced(kTwoCameras, "\t10\n", "\n")), ErrorCode::BadData,
               {"line 15", "R|t", "'01'", "4 numbers"});
  expect_error(parse(replaced(kTwoCameras, "0.0\t0.0\t1.0", "0.0\t0.1\t1.0")), ErrorCode::BadData,
               {"line 4", "K"});
  expect_error(parse(replaced(kTwoCameras, "-1\t0\t0\t20", "1\t0\t0\t20")), ErrorCode::BadData,
               {"line 17", "mirror"});
  expect_error(parse(replaced(kTwoCameras, "\n\n1\n", "\n\nx\n")), ErrorCode::BadData, {"line 10", "index"});
  expect_error(parse(replaced(kTwoCameras, "\n\n1\n", "\n\n0\n")), ErrorCode::BadData, {"two cameras", "00"});
}

TEST(Dome, ReadsWindowsLineEndsAlike) {
  std::string windows;
  for (char c : kTwoCameras) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const Result<ForeignRig> unix_rig = parse(kTwoCameras), windows_rig = parse(windows);
  ASSERT_TRUE(unix_rig.has_value() && windows_rig.has_value());
  expect_same(unix_rig->rig, windows_rig->rig, 1e-300);
}

}  // namespace
}  // namespace floatstage::calib
