#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

const std::string kStudio = R"({"calibDataSource": "160422_calib_norm", "cameras": [
 {"name": "00_00", "type": "hd", "resolution": [1920, 1080], "panel": 0, "node": 0,
  "K": [[1400, 0, 950], [0, 1395, 540], [0, 0, 1]], "distCoef": [-0.3, 0.19, -0.0005, 0.0006, 0.05],
  "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [[10], [-20], [300]]},
 {"name": "00_01", "type": "hd", "resolution": [1920, 1080], "panel": 0, "node": 1,
  "K": [[1400, 0, 950], [0, 1395, 540], [0, 0, 1]], "distCoef": [0, 0, 0, 0, 0],
  "R": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "t": [[0], [0], [250]]}]})";

Result<ForeignRig> panoptic(std::string_view content) {
  return parse_panoptic(content, "calibration_x.json");
}

TEST(Panoptic, IsInCentimetresWithOpenCvsLens) {
  const Result<ForeignRig> rig = panoptic(kStudio);
  ASSERT_THAT(rig, IsOk());
  const RigCamera& c = rig->rig.cameras[0];
  EXPECT_EQ(c.serial, "00_00");
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens{});
  // 5 cm right, 40 cm down of the world's origin, by OpenCV's formula in centimetres.
  const double x = 15.0 / 300, y = 20.0 / 300, r2 = x * x + y * y;
  const double radial = 1 + r2 * (-0.3 + r2 * (0.19 + r2 * 0.05));
  const Eigen::Vector2d expected(
      1400 * (x * radial - 2 * 0.0005 * x * y + 0.0006 * (r2 + 2 * x * x)) + 950 + 0.5,
      1395 * (y * radial - 0.0005 * (r2 + 2 * y * y) + 2 * 0.0006 * x * y) + 540 + 0.5);
  EXPECT_LT((*project(c.model, c.cam_from_world * Eigen::Vector3d(0.05, 0.4, 0)) - expected).norm(), 1e-9);
}

TEST(Panoptic, SaysWhatIsWrong) {
  expect_error(panoptic(replaced(kStudio, "[1920, 1080]", "[0, 1080]")), ErrorCode::BadData,
               {"'00_00'", "resolution"});
  expect_error(panoptic(replaced(kStudio, "[[1, 0, 0]", "[[1, 1, 0]")), ErrorCode::BadData, {"'00_00'"});
  expect_error(panoptic(replaced(kStudio, "-0.3, ", "")), ErrorCode::BadData, {"distCoef"});
  expect_error(panoptic(replaced(kStudio, "00_01", "00_00")), ErrorCode::BadData, {"00_00"});
  expect_error(panoptic(R"({"cameras": 3})"), ErrorCode::BadData, {"calibration_x.json"});
}

TEST(Panoptic, RefusesEveryTruncation) { expect_truncations_refused(kStudio, 2, panoptic); }

}  // namespace
}  // namespace floatstage::calib
