#include <cstdlib>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "calib/detect.h"
#include "calib/target_sheet.h"
#include "core/png.h"
#include "tests/calib/detections.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

constexpr double kDotsPerInch = 254;
constexpr double kPixelsPerMetre = kDotsPerInch / 0.0254;

// What other people's programs make of a print.
Image rasterised(const TempFolder& folder, const std::filesystem::path& file) {
  const std::string out = folder / "picture";
  const std::string command =
      file.extension() == ".pdf"
          ? text("pdftoppm -png -singlefile -r ", kDotsPerInch, " ", file.string(), " ", out)
          : text("rsvg-convert -d ", kDotsPerInch, " -p ", kDotsPerInch, " -o ", out, ".png ", file.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  const Result<Image> image = load_png(out + ".png");
  EXPECT_THAT(image, IsOk());
  return image ? *image : Image();
}

class EveryPrint : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(
    Print, EveryPrint,
    testing::Values("chessboard columns=8 rows=5 square=30mm",
                    "charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 inverted",
                    "charuco columns=5 rows=4 square=40mm marker=30mm dictionary=6x6_250 white-first",
                    "apriltags columns=3 rows=2 tag=66mm gap=19.8mm",
                    "apriltags columns=2 rows=2 tag=66mm gap=19.8mm border=2",
                    "wand positions=0mm,70mm,230mm ball=25mm",
                    "wand positions=0mm,150mm tag=60mm dictionary=apriltag_36h11"));

TEST_P(EveryPrint, IsReadBackWithItsGeometryTrueToScale) {
  const TempFolder folder;
  const TargetDesign design = target(GetParam());
  const Sheet sheet = target_sheets(design)[0];
  const Rigid3 sheet_from_target = sheet.target_from_sheet.inverse();
  const std::vector<Eigen::Vector3d> points = target_points(design);
  for (const char* name : {"target.svg", "target.pdf"}) {
    const auto files = write_sheets(design, folder / name);
    ASSERT_THAT(files, IsOk());
    const Detection found = detect(design, rasterised(folder, files->front()));
    ASSERT_EQ(found.points.size(), points.size()) << name << ": " << found.reason;
    double largest = 0;
    for (const SeenPoint& p : found.points) {
      const Eigen::Vector3d on_sheet = sheet_from_target * points[static_cast<std::size_t>(p.id)];
      largest = std::max(largest, (p.pixel - kPixelsPerMetre * on_sheet.head<2>()).norm());
    }
    EXPECT_LE(largest, 0.7) << name << ": 0.07 mm on paper, the rasteriser's own rounding";
  }
}

TEST(Print, OfATwoSidedBoardShowsTheBackOnTheSecondSheet) {
  const TempFolder folder;
  const TargetDesign design =
      target("two-sided columns=5 rows=4 square=40mm marker=30mm dictionary=5x5_100 thickness=5mm");
  const auto files = write_sheets(design, folder / "b.svg");
  ASSERT_THAT(files, IsOk());
  const Detection front = detect(design, rasterised(folder, (*files)[0])),
                  back = detect(design, rasterised(folder, (*files)[1]));
  ASSERT_EQ(front.points.size(), 12u);
  ASSERT_EQ(back.points.size(), 12u);
  EXPECT_EQ(front.points.front().id, 0);
  EXPECT_EQ(back.points.front().id, 12);
}

}  // namespace
}  // namespace floatstage::calib
