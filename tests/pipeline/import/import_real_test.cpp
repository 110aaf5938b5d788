#include <cstdlib>

#include <gmock/gmock.h>

#include "core/matte.h"
#include "core/png.h"
#include "pipeline/import/import.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

TEST(ImportReal, TempleRingTakesTheNineteenViewsThatHaveAnImage) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"middlebury", real_data("middlebury-temple-ring")};
  options.out = folder / "T";
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->serials.size(), 19u);
  EXPECT_EQ(report->serials.front(), "templeR0013");
  EXPECT_EQ(report->frames, 1);
  EXPECT_THAT(report->notes, testing::ElementsAre(testing::HasSubstr("28 of 47")));
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  const int camera = camera_index((*take)->rig(), "templeR0014.png");
  ASSERT_GE(camera, 0);
  const Result<Image> original = load_png(real_data("middlebury-temple-ring/templeR0014.png"));
  const Result<Frame> frame = (*take)->frame(camera, 0);
  ASSERT_TRUE(original && frame);
  EXPECT_TRUE(*to_rgb(*frame) == *original);
}

TEST(ImportReal, DomeComesWithItsMattes) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"dome", real_data("green-dome")};
  options.mattes = real_data("green-dome/mattes");
  options.out = folder / "G";
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->serials.size(), 20u);
  EXPECT_THAT(report->notes, testing::IsEmpty());
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  EXPECT_EQ((*take)->rig().cameras[3].serial, "03");
  for (const RigCamera& c : (*take)->rig().cameras) {
    const Result<Image> matte = load_png((*take)->layout().matte(c.serial, 0));
    ASSERT_THAT(matte, IsOk());
    EXPECT_EQ(matte->width, 1024);
    const double covered = coverage(make_matte({}, *matte));
    EXPECT_GT(covered, 0.02) << c.serial;
    EXPECT_LT(covered, 0.4) << c.serial;
  }
}

// The videos of cam01 and cam02 were scaled to another size than their calibration's, so they must be
// refused.
TEST(ImportReal, QualisysVideosOfAnotherSizeAreRefusedAndTheOthersTaken) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"qualisys", real_data("pose2sim-balancing/calibration/Calib.qca.txt")};
  options.pictures = real_data("pose2sim-balancing/videos");
  options.frames = {.first = 4, .end = 6};
  options.out = folder / "Q";
  EXPECT_THAT(import_take(options),
              FailsWith(ErrorCode::BadData, "camera 'cam01': its pictures are 1080x1920"));
  EXPECT_THAT(folder.names(), testing::IsEmpty());
  options.cameras = {"cam03", "cam04"};
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->frames, 2);
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  EXPECT_NEAR((*take)->manifest().frame_rate, 60, 1e-6);
}

}  // namespace
}  // namespace floatstage::pipeline
