#include "render/zipmap/zipmap.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/render/zipmap/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::render {
namespace {

using namespace test;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3f;

TEST(MipPyramid, HasAClearBorderAtEveryLevelDownToOneTexelWhateverTheSize) {
  for (const auto& [w, h] : {std::pair(64, 64), {37, 21}, {1, 1}, {2, 300}, {129, 5}, {255, 256}}) {
    const MipPyramid pyramid(Image(w, h, 4, 255), true);
    EXPECT_EQ(pyramid.levels().back().width, 1);
    EXPECT_EQ(pyramid.levels().back().height, 1);
    EXPECT_EQ(pyramid.levels().size(), 1 + static_cast<std::size_t>(std::log2(std::max(w, h))));
    for (const Image& level : pyramid.levels())
      for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
          const bool border = x == 0 || y == 0 || x == level.width - 1 || y == level.height - 1;
          ASSERT_EQ(level.at(x, y)[3], border ? 0 : 255) << w << "x" << h << ": " << level.width;
        }
  }
}

TEST(MipPyramid, OfOddSizesKeepsTheMeanAndDoesNotDrift) {
  Image ramp(45, 27, 3);
  for (int y = 0; y < 27; ++y)
    for (int x = 0; x < 45; ++x) ramp.at(x, y)[0] = static_cast<std::uint8_t>(5 * x);
  const MipPyramid pyramid(ramp, false);
  for (const Image& level : pyramid.levels()) {
    double sum = 0;
    for (int x = 0; x < level.width; ++x) sum += level.at(x, 0)[0];
    EXPECT_NEAR(sum / level.width, 110, 1);
    EXPECT_NEAR(level.at(0, 0)[0] + level.at(level.width - 1, 0)[0], 220, 1.5);
  }
}

TEST(MipPyramid, WeighsColoursByTheirOpacity) {
  Image picture(2, 1, 4);
  picture.pixels = {200, 100, 0, 255, 0, 0, 90, 0};
  const MipPyramid pyramid(picture, false);
  const Image& last = pyramid.levels().back();
  EXPECT_EQ(last.pixels, (std::vector<std::uint8_t>{200, 100, 0, 128}));
}

TEST(Coordinates, AreWrappedAsOpenGlDoes) {
  using W = Zipmap::Wrap;
  EXPECT_DOUBLE_EQ(wrapped(1.25, W::Clamp), 1);
  EXPECT_DOUBLE_EQ(wrapped(-0.25, W::Repeat), 0.75);
  EXPECT_DOUBLE_EQ(wrapped(2.25, W::Repeat), 0.25);
  EXPECT_DOUBLE_EQ(wrapped(-0.25, W::Mirror), 0.25);
  EXPECT_DOUBLE_EQ(wrapped(1.25, W::Mirror), 0.75);
  EXPECT_DOUBLE_EQ(wrapped(-3.25, W::Mirror), 0.75);
}

TEST(AZipmap, ShowsItsPatchWhereItLiesAndItsRootElsewhere) {
  const Image root(32, 32, 3, 60), detail(64, 64, 3, 200);
  const Result<Zipmap> zipmap = Zipmap::make(root, {detail}, {patch(0, 0.25, 0.5, 0.25)});
  ASSERT_THAT(zipmap, IsOk());
  const Vector2d du(1e-4, 0), dv(0, 1e-4);
  EXPECT_NEAR(zipmap->shade({0.375, 0.625}, du, dv)[0], 200 / 255.0, 1e-5);
  EXPECT_NEAR(zipmap->shade({0.1, 0.1}, du, dv)[0], 60 / 255.0, 1e-5);
  EXPECT_NEAR(zipmap->shade({0.25, 0.6}, du, dv)[0], 60 / 255.0, 1e-5) << "its edge is clear";
  EXPECT_NEAR(zipmap->shade({1.375, -0.375}, du, dv, Zipmap::Wrap::Repeat)[0], 200 / 255.0, 1e-5);
  EXPECT_NEAR(zipmap->shade({1.625, 0.625}, du, dv, Zipmap::Wrap::Mirror)[0], 200 / 255.0, 1e-5);
}

TEST(AZipmap, WhosePatchesShowTheRootsColoursHasNoSeams) {
  const Image root(64, 64, 3, 123);
  std::vector<Zipmap::Patch> patches;
  for (int i = 0; i < 9; ++i) patches.push_back(patch(0, 0.1 + 0.05 * i, 0.13 + 0.031 * i, 0.3));
  const Zipmap zipmap = *Zipmap::make(root, {Image(100, 77, 3, 123)}, patches);
  for (const double size : {2.0, 1.0, 0.4, 0.05})
    EXPECT_THAT(zipmap.draw(window(0.2, 0.2, size, 97), 97, 80).pixels, testing::Each(123)) << size;
}

TEST(AZipmap, InSeveralPassesIsThatInOne) {
  for (const int count : {1, 15, 16, 40, 255}) {
    Random random(9);
    const Zipmap zipmap = scattered(count);
    const std::size_t all = zipmap.patches().size();
    const Vector2d du(0.004, 0), dv(0, 0.004);
    for (int i = 0; i < 50; ++i) {
      const Vector2d uv(random.uniform(-1, 2), random.uniform(-1, 2));
      const Vector3f one = zipmap.shade(uv, du, dv, Zipmap::Wrap::Repeat);
      Vector3f passes = Zipmap::make(noise(40, 30, 3, 1), {}, {})->shade(uv, du, dv, Zipmap::Wrap::Repeat);
      for (std::size_t first = 0; first < all; first += 15)
        passes =
            zipmap.shade_over(passes, uv, du, dv, first, std::min(first + 15, all), Zipmap::Wrap::Repeat);
      ASSERT_EQ(one, passes) << count;
    }
  }
}

TEST(AZipmap, DoesNotPopWhileOneZoomsIn) {
  const Zipmap zipmap = ever_closer();
  double size = 1, most = 0;
  Image before = zipmap.draw(window(0, 0, 1, 160), 160, 120);
  for (int step = 0; step < 350; ++step) {
    size *= 0.99;
    const Image now = zipmap.draw(window(0.5 - size / 2, 0.5 - size * 3 / 8, size, 160), 160, 120);
    if (step > 0) most = std::max(most, mean_difference(before, now));
    before = now;
  }
  EXPECT_LE(most, 2) << "steps of 255 from one per cent to the next";
}

TEST(AZipmap, TakesAHundredMegabytesWhereAFlatTextureTakesSeventeenThousand) {
  const Zipmap zipmap = thirty_two_times();
  EXPECT_NEAR(zipmap.finest(), 32, 1e-9);
  EXPECT_LE(static_cast<double>(zipmap.bytes()), 110e6);
  EXPECT_GT(zipmap.bytes_when_flat(), 17e9);
}

TEST(AZipmap, IsDrawnTheSameByAnyNumberOfThreads) {
  const Zipmap zipmap = *Zipmap::make(noise(50, 40, 3, 1), {noise(30, 30, 4, 2)}, {patch(0, 0.2, 0.2, 0.5)});
  Matrix3d oblique = window(0, 0, 1, 90);
  oblique(2, 0) = 0.004;
  EXPECT_EQ(zipmap.draw(oblique, 90, 70, Zipmap::Wrap::Mirror, 1),
            zipmap.draw(oblique, 90, 70, Zipmap::Wrap::Mirror, 2));
}

TEST(AZipmap, SaysWhatIsWrongWithWhatItIsMadeOf) {
  const Image root(8, 8, 3);
  EXPECT_THAT(Zipmap::make(Image(), {}, {}), FailsWith(ErrorCode::InvalidArgument, "root"));
  EXPECT_THAT(Zipmap::make(root, {Image(4, 4, 1)}, {}), FailsWith(ErrorCode::InvalidArgument, "picture 0"));
  EXPECT_THAT(Zipmap::make(root, {}, {patch(0, 0, 0, 1)}), FailsWith(ErrorCode::InvalidArgument, "patch 0"));
  EXPECT_THAT(Zipmap::make(root, {root}, {{0, Matrix3d::Zero()}}),
              FailsWith(ErrorCode::InvalidArgument, "inverse"));
}

}  // namespace
}  // namespace floatstage::render
