#include "matting/method_selection.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

Image disc(double radius) {
  Scene scene;
  scene.radius = radius;
  return to_image(truth(scene));
}

TEST(CompositeResiduals, AreLeastForTheTruth) {
  Scene scene;
  scene.noise = 2;
  const std::vector<double> r =
      composite_residuals(photograph(scene), {disc(27), disc(30), disc(33), disc(30.7)});
  EXPECT_LT(r[1], r[0]);
  EXPECT_LT(r[1], r[2]);
  EXPECT_LT(r[1], r[3]);
}

TEST(CompositeResiduals, SeeAMissingPartThatOneCandidateHas) {
  Image torn = disc(30);
  for (int y = 45; y < 75; ++y) std::fill_n(torn.at(60, y), 12, std::uint8_t{0});
  const std::vector<double> r = composite_residuals(photograph(Scene{}), {torn, disc(30)});
  EXPECT_GT(r[0], 3 * r[1]);
}

TEST(CompositeResiduals, UseThePlateWhereTheBackgroundChangesColour) {
  Scene scene;
  Image empty = empty_stage(scene), picture = photograph(scene);
  for (int y = 0; y < 120; ++y)  // a red curtain begins right beside the subject
    for (int x = 112; x < 160; ++x)
      for (Image* image : {&empty, &picture})
        image->at(x, y)[0] = 170, image->at(x, y)[1] = 60, image->at(x, y)[2] = 60;
  const Plate plate = *learn_plate({empty});
  const Image fooled = disc(36);
  EXPECT_LT(composite_residuals(picture, {disc(30), fooled}, &plate)[0],
            composite_residuals(picture, {disc(30), fooled}, &plate)[1]);
}

TEST(CompositeResiduals, RefuseAnEmptyCandidateBesideOneWithASubject) {
  const std::vector<double> r =
      composite_residuals(photograph(Scene{}), {Image(160, 120, 1), disc(30), Image(80, 60, 1)});
  EXPECT_TRUE(std::isinf(r[0]));
  EXPECT_TRUE(std::isfinite(r[1]));
  EXPECT_TRUE(std::isinf(r[2]));
  EXPECT_EQ(composite_residuals(photograph(Scene{}), {Image(160, 120, 1)})[0], 0) << "nobody on stage";
}

TEST(MethodComparison, PrefersTheCalmerOfTwoThatComposeAlike) {
  const Image picture = photograph(Scene{});
  MethodComparison comparison(2);
  EXPECT_EQ(comparison.best(), 0u) << "nothing was said yet";
  comparison.add(picture, {disc(30), disc(30)});
  EXPECT_EQ(comparison.scores()[0], comparison.scores()[1]);
  comparison.add_pair(picture, {disc(24), disc(30)}, picture, {disc(30), disc(30)});
  EXPECT_LT(comparison.scores()[1], 0.5 * comparison.scores()[0]);
  EXPECT_EQ(comparison.best(), 1u);
  EXPECT_EQ(comparison.best(0), 1u) << "the usual one flickers";
}

TEST(MethodComparison, TakesTheUsualOneWhereScoresHardlyDiffer) {
  const Image picture = photograph(Scene{});
  MethodComparison comparison(2);
  comparison.add(picture, {disc(30), disc(30)});
  comparison.add_pair(picture, {disc(24), disc(23.9)}, picture, {disc(30), disc(30)});
  ASSERT_LT(comparison.scores()[0], comparison.scores()[1]);
  EXPECT_EQ(comparison.best(), 0u);
  EXPECT_EQ(comparison.best(1), 1u);
}

TEST(MethodComparison, NeverPrefersNobodyHoweverCalm) {
  const Image picture(80, 60, 3, 100), nobody(80, 60, 1);
  Image somebody(80, 60, 1), moved(80, 60, 1);
  for (int y = 20; y < 40; ++y)
    std::fill_n(somebody.at(20, y), 20, std::uint8_t{255}),
        std::fill_n(moved.at(30, y), 20, std::uint8_t{255});
  MethodComparison comparison(2);
  comparison.add(picture, {nobody, somebody});
  comparison.add_pair(picture, {nobody, moved}, picture, {nobody, somebody});
  EXPECT_EQ(comparison.best(), 1u);
}

}  // namespace
}  // namespace floatstage::matting
