#include "calib/scene_keypoints.h"

#include <cmath>

#include <gtest/gtest.h>

#include "calib/markerless.h"

namespace floatstage::calib {
namespace {

// Soft bright spots on grey, at these places (corner origin).
Image spots(const std::vector<Eigen::Vector2d>& places, double radius) {
  Image picture(160, 120, 1);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      double value = 60;
      for (const Eigen::Vector2d& p : places)
        value +=
            150 * std::exp(-(p - Eigen::Vector2d(x + 0.5, y + 0.5)).squaredNorm() / (2 * radius * radius));
      *picture.at(x, y) = static_cast<std::uint8_t>(std::lround(std::min(value, 255.0)));
    }
  return picture;
}

TEST(SceneKeypoints, LieWhereTheSpotIsFromThePicturesCorner) {
  for (const double radius : {2.0, 4.0})
    for (const Eigen::Vector2d& place :
         {Eigen::Vector2d(80, 60), Eigen::Vector2d(60.3, 70.8), Eigen::Vector2d(90.5, 50.5)}) {
      const SceneKeypoints found = find_keypoints(spots({place}, radius), kUsualContrast);
      ASSERT_FALSE(found.keypoints.empty());
      double nearest = 1e9;
      for (const SceneKeypoints::Keypoint& k : found.keypoints)
        nearest = std::min(nearest, (k.pixel - place).norm());
      EXPECT_LT(nearest, 0.06) << place.transpose() << " radius " << radius;
    }
}

TEST(SceneKeypoints, AreTheSameAgainAndOnesDescriptorIsLong) {
  const Image picture = spots({{40, 40}, {47, 43}, {100, 70}, {104, 79}}, 2.5);
  const SceneKeypoints one = find_keypoints(picture, kUsualContrast),
                       other = find_keypoints(picture, kUsualContrast);
  ASSERT_GE(one.keypoints.size(), 4u);
  ASSERT_EQ(one.descriptors.size(), one.keypoints.size());
  EXPECT_EQ(one.descriptors, other.descriptors);
  for (const SceneKeypoints::Descriptor& d : one.descriptors) {
    double squares = 0;
    for (const std::int16_t v : d) {
      EXPECT_GE(v, 0);
      EXPECT_LE(v, 255);
      squares += static_cast<double>(v) * v;
    }
    EXPECT_NEAR(std::sqrt(squares), 512, 8);
  }
}

TEST(ContrastOfAScene, IsTheUsualOneUnlessPicturesShowLittle) {
  Image busy(320, 240, 1), faint(320, 240, 1);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const int noise = (x * 7919 + y * 104729 + x * y * 31) % 97;
      *busy.at(x, y) = static_cast<std::uint8_t>(80 + noise);
      *faint.at(x, y) = static_cast<std::uint8_t>(100 + x / 16);
    }
  EXPECT_EQ(contrast_for(std::vector<Image>{busy, busy, faint}, 1), kUsualContrast);
  EXPECT_EQ(contrast_for(std::vector<Image>{faint, busy, faint}, 1), kUsualContrast / 4);
}

TEST(SceneKeypoints, OfAnEmptyPictureAreNone) {
  EXPECT_TRUE(find_keypoints(Image(64, 48, 3, 128), kUsualContrast).keypoints.empty());
}

}  // namespace
}  // namespace floatstage::calib
