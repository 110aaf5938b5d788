#include "render/zipmap/zipmap.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3f;

Image noise(int width, int height, int channels, std::uint64_t seed) {
  Random random(seed);
  Image image(width, height, channels);
  for (std::uint8_t& v : image.pixels) v = static_cast<std::uint8_t>(random.next() & 255);
  return image;
}

// Over the part of the root that begins at (u, v) and is `size` wide and high.
Zipmap::Patch patch(std::size_t picture, double u, double v, double size) {
  Zipmap::Patch p{picture, Matrix3d::Identity()};
  p.patch_from_root(0, 0) = p.patch_from_root(1, 1) = 1 / size;
  p.patch_from_root(0, 2) = -u / size;
  p.patch_from_root(1, 2) = -v / size;
  return p;
}

// A window of the root, `size` wide, on so many pixels.
Matrix3d window(double u, double v, double size, int width) {
  Matrix3d m = Matrix3d::Identity();
  m(0, 0) = m(1, 1) = size / width;
  m(0, 2) = u;
  m(1, 2) = v;
  return m;
}

double mean_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / static_cast<double>(a.pixels.size());
}

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
  const Image& last = MipPyramid(picture, false).levels().back();
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
    Random random(7);
    std::vector<Zipmap::Patch> patches;
    for (int i = 0; i < count; ++i)
      patches.push_back(
          patch(static_cast<std::size_t>(i % 3), random.uniform(0, 0.7), random.uniform(0, 0.7), 0.3));
    const Zipmap zipmap = *Zipmap::make(
        noise(40, 30, 3, 1), {noise(20, 20, 4, 2), noise(31, 17, 4, 3), noise(64, 64, 4, 4)}, patches);
    const Vector2d du(0.004, 0), dv(0, 0.004);
    for (int i = 0; i < 50; ++i) {
      const Vector2d uv(random.uniform(-1, 2), random.uniform(-1, 2));
      const Vector3f one = zipmap.shade(uv, du, dv, Zipmap::Wrap::Repeat);
      Vector3f passes = Zipmap::make(noise(40, 30, 3, 1), {}, {})->shade(uv, du, dv, Zipmap::Wrap::Repeat);
      for (std::size_t first = 0; first < patches.size(); first += 15)
        passes = zipmap.shade_over(passes, uv, du, dv, first, std::min(first + 15, patches.size()),
                                   Zipmap::Wrap::Repeat);
      ASSERT_EQ(one, passes) << count;
    }
  }
}

TEST(AZipmap, DoesNotPopWhileOneZoomsIn) {
  // Patches that show the same thing ever closer, as photographs do.
  const auto scene = [](double u, double v) {
    // Gentle enough that what moves by a pixel's part changes little: what is left are jumps.
    return 128 + 50 * std::sin(6 * u + 3 * v) + 12 * std::sin(90 * u * v) + 4 * std::cos(220 * v + 11 * u);
  };
  const auto photograph = [&](double u, double v, double size, int n) {
    Image image(n, n, 3);
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y)[c] = static_cast<std::uint8_t>(
              std::clamp(scene(u + size * (x + 0.5) / n, v + size * (y + 0.5) / n), 0.0, 255.0));
    return image;
  };
  const Zipmap zipmap = *Zipmap::make(
      photograph(0, 0, 1, 256),
      {photograph(0.3, 0.3, 0.4, 256), photograph(0.42, 0.42, 0.16, 256), photograph(0.47, 0.47, 0.06, 256)},
      {patch(0, 0.3, 0.3, 0.4), patch(1, 0.42, 0.42, 0.16), patch(2, 0.47, 0.47, 0.06)});
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
  // 32x into 2048²: a root and five photographs of its size, each twice as close as the last.
  std::vector<Image> pictures;
  std::vector<Zipmap::Patch> patches;
  double size = 1;
  for (std::size_t i = 0; i < 4; ++i) {
    pictures.emplace_back(2048, 2048, 3, 90);
    size /= i == 3 ? 4 : 2;
    patches.push_back(patch(i, 0.5 - size / 2, 0.5 - size / 2, size));
  }
  const Zipmap zipmap = *Zipmap::make(Image(2048, 2048, 3, 80), pictures, patches);
  EXPECT_NEAR(zipmap.finest(), 32, 1e-9);
  EXPECT_LE(static_cast<double>(zipmap.bytes()), 115e6);
  EXPECT_LE(static_cast<double>(zipmap.bytes()) / (1 << 20), 110) << "MiB";
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
