#include "pipeline/view_array.h"

#include <gtest/gtest.h>

#include "pipeline/camera_path.h"

namespace floatstage::pipeline {
namespace {

constexpr double kScreen = 3;  // metres

View middle() {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(1, 1, 2));
  return view_of({.time = 0, .eye = {0, -3, 1}, .target = {0, 0, 1}, .up = {0, 0, 1}, .fov_y = 40}, 640, 480,
                 box);
}

double column(const View& view, const Eigen::Vector3d& at_depth) {
  const Eigen::Vector3d world = middle().view_from_world.inverse() * at_depth;
  const Eigen::Vector3d seen = view.view_from_world * world;
  return view.model.cx + view.model.fx * seen.x() / seen.z();
}

TEST(ViewArray, WhatLiesInTheScreenStandsAtOnePlaceAndWhatIsNearerComesOut) {
  const std::vector<View> eyes = views_of(middle(), {.views = 2, .baseline = 0.06}, kScreen);
  ASSERT_EQ(eyes.size(), 2u);
  EXPECT_NEAR(column(eyes[0], {0.4, 0.2, kScreen}), column(eyes[1], {0.4, 0.2, kScreen}), 1e-9);
  const double nearer = column(eyes[0], {0, 0, 2}) - column(eyes[1], {0, 0, 2});
  const double farther = column(eyes[0], {0, 0, 6}) - column(eyes[1], {0, 0, 6});
  EXPECT_NEAR(nearer, middle().model.fx * 0.06 * (1 / 2. - 1 / kScreen), 1e-9) << "crossed";
  EXPECT_NEAR(farther, middle().model.fx * 0.06 * (1 / 6. - 1 / kScreen), 1e-9) << "uncrossed";
  EXPECT_GT(nearer, 0);
  EXPECT_LT(farther, 0);
}

TEST(ViewArray, EyesStandInARowAroundTheMiddleAndLookTheSameWay) {
  const View one = middle();
  const std::vector<View> eyes = views_of(one, {.views = 3, .baseline = 0.1}, kScreen);
  const Eigen::Vector3d right = one.view_from_world.rotation.conjugate() * Eigen::Vector3d::UnitX();
  for (int i = 0; i < 3; ++i) {
    const View& eye = eyes[static_cast<std::size_t>(i)];
    EXPECT_LT((eye.view_from_world.center() - one.view_from_world.center() - (i - 1) * 0.1 * right).norm(),
              1e-12);
    EXPECT_EQ(eye.view_from_world.rotation.coeffs(), one.view_from_world.rotation.coeffs());
  }
  EXPECT_EQ(eyes[1].model.cx, one.model.cx);
}

TEST(ViewArray, PicturesStandFromLeftToRightThenDown) {
  std::vector<Image> pictures;
  for (int i = 0; i < 5; ++i) pictures.emplace_back(2, 1, 3, static_cast<std::uint8_t>(10 * (i + 1)));
  const ViewArray five = {.views = 5};
  EXPECT_EQ(columns_of(five), 3);
  EXPECT_EQ(rows_of(five), 2);
  const Image all = tiled(pictures, five);
  EXPECT_EQ(all.width, 6);
  EXPECT_EQ(all.height, 2);
  EXPECT_EQ(*all.at(4, 0), 30);
  EXPECT_EQ(*all.at(2, 1), 50);
  EXPECT_EQ(*all.at(4, 1), 0) << "no sixth";
  EXPECT_EQ(columns_of({.views = 3}), 3);
  EXPECT_EQ(rows_of({.views = 3}), 1);
  EXPECT_EQ(columns_of({.views = 8}), 4);
}

}  // namespace
}  // namespace floatstage::pipeline
