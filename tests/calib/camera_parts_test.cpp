#include "calib/formats/camera_parts.h"

#include <Eigen/Geometry>

#include "calib/formats/text_lines.h"
#include "tests/calib/format_support.h"

namespace floatstage::calib {
namespace {

const Eigen::Matrix3d kTurned =
    Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();

TEST(ForeignRotation, IsMadeOrthonormalWithinRounding) {
  Eigen::Matrix3d rounded = kTurned;
  rounded(0, 0) += 2e-4;
  rounded(2, 1) -= 2e-4;
  const Result<Eigen::Quaterniond> q = rotation_from_matrix(rounded);
  ASSERT_TRUE(q.has_value()) << q.error().message;
  EXPECT_NEAR(q->norm(), 1, 1e-15);
  EXPECT_LT((q->toRotationMatrix() - kTurned).cwiseAbs().maxCoeff(), 2e-4);
}

TEST(ForeignRotation, IsRefusedBeyondRounding) {
  Eigen::Matrix3d off = kTurned;
  off(0, 0) += 5e-3;
  expect_error(rotation_from_matrix(off), ErrorCode::BadData, {"orthonormal"});
  expect_error(rotation_from_matrix(kTurned * 1.001), ErrorCode::BadData, {"orthonormal"});
  expect_error(rotation_from_matrix(Eigen::Matrix3d::Zero()), ErrorCode::BadData, {"orthonormal"});
}

TEST(ForeignRotation, IsRefusedWhenItIsAMirror) {
  Eigen::Matrix3d mirror = kTurned;
  mirror.col(1) *= -1;
  expect_error(rotation_from_matrix(mirror), ErrorCode::BadData, {"mirror"});
}

TEST(ForeignRotation, IsRefusedWhenNotFinite) {
  Eigen::Matrix3d bad = kTurned;
  bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
  expect_error(rotation_from_matrix(bad), ErrorCode::BadData, {"not finite"});
}

TEST(PixelOrigin, LiesHalfAPixelApart) {
  EXPECT_EQ(to_corner_origin(0.5, PixelOrigin::FirstPixelCenter), 1.0);
  EXPECT_EQ(to_corner_origin(0.5, PixelOrigin::ImageCorner), 0.5);
  EXPECT_EQ(from_corner_origin(1.0, PixelOrigin::FirstPixelCenter), 0.5);
}

TEST(ForeignSerial, IsUsableAsAFileName) {
  EXPECT_EQ(serial_from_name("a/b c.png"), "a_b_c");
  EXPECT_EQ(serial_from_name("../x"), "_._x");
  EXPECT_EQ(serial_from_name("templeR0014.png"), "templeR0014");
}

TEST(TextLines, CountsLinesOfEverySystem) {
  TextLines lines("a\r\nb\rc\n\nd", "f");
  for (const char* expected : {"a", "b", "c", "", "d"}) {
    const std::optional<TextLine> line = lines.next();
    ASSERT_TRUE(line.has_value());
    EXPECT_EQ(line->whole, expected);
  }
  EXPECT_FALSE(lines.next().has_value());
  EXPECT_EQ(lines.bad("x").error_value.message, "f: line 5: x");
}

TEST(TextLines, TakesOnlyWholeFiniteNumbers) {
  EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
  EXPECT_EQ(parse_number("+2"), 2.0);
  for (const char* bad : {"", "nan", "inf", "-inf", "1.5x", "1,5", "1e999", "0x10", "+-1", "--1"})
    EXPECT_FALSE(parse_number(bad).has_value()) << bad;
}

TEST(TextLines, WritesNumbersThatReadBackTheSame) {
  for (double v : {0.1, 1.0 / 3, -2e-300, 1234567.875}) EXPECT_EQ(parse_number(to_text(v)), v);
}

}  // namespace
}  // namespace floatstage::calib
