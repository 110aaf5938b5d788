#include "matting/pyramid_matte.h"

#include <algorithm>
#include <cmath>

#include "tests/matting/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

struct Still {
  Image picture, trimap, truth;
};

// The dancer before cloth, unknown within about `margin` px of her outline and hair.
Still dancer(std::uint64_t seed, int margin) {
  ClipOptions options;
  options.frames = 1;
  options.seed = seed;
  MatteClip clip = make_clip(studio_cutout(seed), green_cloth(360, 240, seed), options);
  Image trimap = trimap_around(clip.truth[0], {.margin = margin, .soft_from = 1, .soft_to = 254});
  return {std::move(clip.frames[0]), std::move(trimap), std::move(clip.truth[0])};
}

// Mean squared error of opacity, 0 to 1, where the trimap knows nothing.
double error(const Result<Image>& matte, const Still& still) {
  EXPECT_THAT(matte, IsOk());
  if (!matte) return 1;
  double sum = 0;
  long count = 0;
  for (std::size_t p = 0; p < still.truth.pixels.size(); ++p) {
    if (still.trimap.pixels[p] == 0 || still.trimap.pixels[p] == 255) continue;
    sum += std::pow((matte->pixels[p] - still.truth.pixels[p]) / 255.0, 2);
    ++count;
  }
  return sum / static_cast<double>(count);
}

TEST(PyramidMatte, DecidesWhatIsFarFromAnythingKnownBetterThanClosedFormAlone) {
  for (const std::uint64_t seed : {1, 2}) {
    const Still still = dancer(seed, 10);
    const double alone = error(closed_form_matte(still.picture, still.trimap), still),
                 held = error(pyramid_matte(still.picture, still.trimap), still);
    EXPECT_LE(held, 0.6 * alone) << "seed " << seed;
    EXPECT_LE(held, 5e-3) << "seed " << seed;
  }
}

TEST(PyramidMatte, IsAboutAsGoodInANarrowBand) {
  const Still still = dancer(1, 3);
  EXPECT_LE(error(pyramid_matte(still.picture, still.trimap), still),
            error(closed_form_matte(still.picture, still.trimap), still) + 2e-4);
}

TEST(PyramidMatte, KeepsWhatIsKnown) {
  const Still still = dancer(2, 10);
  const Result<Image> matte = pyramid_matte(still.picture, still.trimap);
  ASSERT_THAT(matte, IsOk());
  int worst = 0;
  for (std::size_t p = 0; p < matte->pixels.size(); ++p)
    if (still.trimap.pixels[p] == 0 || still.trimap.pixels[p] == 255)
      worst = std::max(worst, std::abs(matte->pixels[p] - still.trimap.pixels[p]));
  EXPECT_LE(worst, 1);
}

// Half the size would not know of it.
TEST(PyramidMatte, IsClosedFormWhereTheSubjectIsKnownByAThinLineOnly) {
  const Still still = dancer(1, 10);
  Image trimap = still.trimap;
  for (std::uint8_t& v : trimap.pixels) v = v == 255 ? 128 : v;
  for (int y = 100; y < 140; ++y) *trimap.at(180, y) = 255;
  const Result<Image> alone = closed_form_matte(still.picture, trimap);
  ASSERT_THAT(alone, IsOk());
  EXPECT_THAT(pyramid_matte(still.picture, trimap), IsOkAnd(*alone));
}

TEST(PyramidMatte, SolvesALargeBandInStripsThatCannotBeTold) {
  const Still still = dancer(1, 6);
  const Result<Image> whole = pyramid_matte(still.picture, still.trimap);
  PyramidOptions options;
  options.solve.most_unknown = 7000;
  const Result<Image> strips = pyramid_matte(still.picture, still.trimap, options);
  ASSERT_THAT(whole, IsOk());
  ASSERT_THAT(strips, IsOk());
  const long unknown = std::count(still.trimap.pixels.begin(), still.trimap.pixels.end(), 128);
  ASSERT_GT(unknown, options.solve.most_unknown);
  int worst = 0;
  for (std::size_t p = 0; p < whole->pixels.size(); ++p)
    worst = std::max(worst, std::abs(whole->pixels[p] - strips->pixels[p]));
  EXPECT_LE(worst, 2);
}

TEST(PyramidMatte, TakesPicturesOfAnySizeThatClosedFormTakes) {
  for (const int side : {3, 7, 41, 64}) {
    Image picture(side, side, 3, 40), trimap(side, side, 1, 128);
    for (int y = 0; y < side; ++y)
      for (int x = side / 2; x < side; ++x) std::fill_n(picture.at(x, y), 3, 200);
    for (int y = 0; y < side; ++y) *trimap.at(0, y) = 0, *trimap.at(side - 1, y) = 255;
    const Result<Image> matte = pyramid_matte(picture, trimap);
    ASSERT_THAT(matte, IsOk()) << side;
    EXPECT_LT(*matte->at(1, side / 2), side == 3 ? 256 : 30) << side;
    EXPECT_GT(*matte->at(side - 2, side / 2), side == 3 ? -1 : 225) << side;
  }
}

TEST(PyramidMatte, SaysWhichOptionDoesNotFit) {
  const Still still = dancer(1, 3);
  PyramidOptions options;
  options.hold = -1;
  EXPECT_THAT(pyramid_matte(still.picture, still.trimap, options),
              FailsWith(ErrorCode::InvalidArgument, "hold"));
  options = {};
  options.smallest_side = 2;
  EXPECT_THAT(pyramid_matte(still.picture, still.trimap, options),
              FailsWith(ErrorCode::InvalidArgument, "smallest_side"));
  EXPECT_THAT(pyramid_matte(still.picture, Image(10, 10, 1, 128)),
              FailsWith(ErrorCode::InvalidArgument, "10x10"));
  EXPECT_THAT(pyramid_matte(still.picture, Image(360, 240, 1, 128)),
              FailsWith(ErrorCode::InvalidArgument, "known"));
}

}  // namespace
}  // namespace floatstage::matting
