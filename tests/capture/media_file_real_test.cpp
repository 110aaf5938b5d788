// Others' pictures and videos, as cameras and tools really write them.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/png.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::capture {
namespace {

class RealMedia : public testing::Test {
 protected:
  void SetUp() override { FLOATSTAGE_NEEDS_DATA(data_); }
  const std::filesystem::path data_ = real_data("");
};

int pictures_of(const std::filesystem::path& file, int width, int height) {
  auto reader = MediaReader::open(file);
  EXPECT_THAT(reader, IsOk());
  if (!reader) return 0;
  int pictures = 0;
  for (;; ++pictures) {
    const Result<Image> image = (*reader)->next();
    if (!image) {
      EXPECT_THAT(image, FailsWith(ErrorCode::EndOfStream, file.filename().string()));
      return pictures;
    }
    EXPECT_EQ(image->width, width);
    EXPECT_EQ(image->height, height);
  }
}

TEST_F(RealMedia, AVideoHasAllItsPictures) {
  EXPECT_EQ(
      pictures_of(data_ / "caliscope-4cam/charuco_calibration/calibration/extrinsic/cam_0.mp4", 1280, 720),
      111);
}

TEST_F(RealMedia, APortraitVideoStandsUpright) {
  EXPECT_EQ(pictures_of(data_ / "pose2sim-balancing/videos/cam01.mp4", 1080, 1920), 100);
}

TEST_F(RealMedia, APhotographIsThatOfLibpng) {
  const auto file = data_ / "middlebury-temple-ring/templeR0013.png";
  auto reader = MediaReader::open(file);
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->next().value(), load_png(file).value());
}

TEST_F(RealMedia, AOneBitMatteIsBlackAndWhite) {
  const auto file = data_ / "green-dome/mattes/00.png";
  auto reader = MediaReader::open(file);
  ASSERT_THAT(reader, IsOk());
  const Image rgb = (*reader)->next().value(), matte = load_png(file).value();
  ASSERT_EQ(rgb.width, matte.width);
  int different = 0;
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      for (int c = 0; c < 3; ++c) different += rgb.at(x, y)[c] != matte.at(x, y)[0];
  EXPECT_EQ(different, 0);
}

TEST_F(RealMedia, AJpegHasItsSize) {
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data_ / "lightfield-shop")) {
    if (entry.path().extension() != ".jpg") continue;
    EXPECT_EQ(pictures_of(entry.path(), 960, 640), 1) << entry.path();
    if (++files == 3) break;
  }
  EXPECT_EQ(files, 3);
}

}  // namespace
}  // namespace floatstage::capture
