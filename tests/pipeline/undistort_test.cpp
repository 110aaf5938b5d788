#include "pipeline/undistort.h"

#include <cmath>

#include <gtest/gtest.h>

namespace floatstage::pipeline {
namespace {

CameraModel model_with(Lens lens) {
  return {.width = 160, .height = 120, .fx = 130, .fy = 130, .cx = 80, .cy = 60, .skew = 0, .lens = lens};
}

// A smooth picture of directions in space, taken through any lens: what a point looks like depends on its ray
// only.
Image photograph(const CameraModel& model) {
  Image image(model.width, model.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto ray = unproject(model, {x + 0.5, y + 0.5});
      if (ray)
        image.at(x, y)[0] = static_cast<std::uint8_t>(
            std::lround(128 + 60 * std::sin(9 * ray->x()) * std::cos(11 * ray->y())));
    }
  return image;
}

TEST(Undistorted, IsThePictureThatAPinholeWouldHaveTaken) {
  for (const Lens& lens :
       {Lens{BrownConrady{-0.15, 0.03, 0.002, -0.001, 0}}, Lens{BrownConrady{0.08, 0, 0, 0, 0}}}) {
    const Image straight = undistorted(photograph(model_with(lens)), model_with(lens)),
                expected = photograph(model_with({}));
    int worst = 0;
    for (int y = 15; y < 105; ++y)
      for (int x = 20; x < 140; ++x)
        worst = std::max(worst, std::abs(straight.at(x, y)[0] - expected.at(x, y)[0]));
    EXPECT_LE(worst, 2);
  }
}

TEST(Undistorted, LeavesThePictureOfALenslessCameraAsItIs) {
  const Image image = photograph(model_with({}));
  EXPECT_EQ(undistorted(image, model_with({})), image);
}

TEST(Undistorted, LeavesBlackWhatThePhotographDoesNotShow) {
  const CameraModel model =
      model_with(BrownConrady{0.3, 0, 0, 0, 0});  // the corners of the ideal picture lie outside
  EXPECT_EQ(undistorted(Image(160, 120, 1, 200), model).at(0, 0)[0], 0);
}

}  // namespace
}  // namespace floatstage::pipeline
