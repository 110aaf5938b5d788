#include <algorithm>
#include <cmath>
#include <iostream>

#include "core/png.h"
#include "core/text.h"
#include "matting/pyramid_matte.h"
#include "matting/spectral_matte.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

// Photographs with a trimap, against their true opacity.
namespace floatstage::matting {
namespace {

struct Still {
  Image picture, trimap, truth;
};

// The first channels of a picture.
Image of_channels(int wanted, const Image& image) {
  Image out(image.width, image.height, wanted);
  const std::size_t from = static_cast<std::size_t>(image.channels), to = static_cast<std::size_t>(wanted);
  for (std::size_t p = 0; p < out.pixels.size() / to; ++p)
    std::copy_n(image.pixels.data() + p * from, to, out.pixels.data() + p * to);
  return out;
}

Still load(const std::filesystem::path& picture, const std::filesystem::path& trimap,
           const std::filesystem::path& truth) {
  Result<Image> i = load_png(picture), t = load_png(trimap), a = load_png(truth);
  EXPECT_THAT(i, IsOk());
  EXPECT_THAT(t, IsOk());
  EXPECT_THAT(a, IsOk());
  if (!i || !t || !a) return {};
  return {of_channels(3, *i), of_channels(1, *t), of_channels(1, *a)};
}

bool is_known(std::uint8_t v) { return v == 0 || v == 255; }

// Thousandths of squared opacity where the trimap knows nothing.
double error(const Result<Image>& matte, const Still& still) {
  EXPECT_THAT(matte, IsOk());
  if (!matte) return 1000;
  double sum = 0;
  long count = 0;
  for (std::size_t p = 0; p < still.truth.pixels.size(); ++p) {
    if (is_known(still.trimap.pixels[p])) continue;
    sum += std::pow((matte->pixels[p] - still.truth.pixels[p]) / 255.0, 2);
    ++count;
  }
  return 1000 * sum / static_cast<double>(count);
}

Result<Image> spectral(const Still& still) {
  MatteConstraint said{still.trimap, still.trimap};
  for (std::uint8_t& w : said.weight.pixels) w = is_known(w) ? 255 : 0;
  return spectral_matte(still.picture, said);
}

TEST(Stills, OfFurGlassAndFluffAreNeverWorseFromCoarseToFineThanByAnotherMethod) {
  const auto folder = real_data("stills-composition");
  FLOATSTAGE_NEEDS_DATA(folder);
  double sum = 0;
  for (int i = 0; i < 5; ++i) {
    const Still still =
        load(folder / text(i, "_image.png"), folder / text(i, "_trimap.png"), folder / text(i, "_alpha.png"));
    ASSERT_FALSE(still.picture.empty());
    const double held = error(pyramid_matte(still.picture, still.trimap), still),
                 alone = error(closed_form_matte(still.picture, still.trimap), still),
                 components = error(spectral(still), still);
    std::cout << "still " << i << ": from coarse to fine " << held << ", closed form " << alone
              << ", spectral " << components << " (thousandths)\n";
    EXPECT_LE(held, 1.05 * std::min(alone, components)) << i;
    sum += held;
  }
  std::cout << "mean " << sum / 5 << "\n";
  EXPECT_LE(sum / 5, 60);
}

// The method was not chosen on it.
TEST(Stills, OfTheLemurIsNoWorseFromCoarseToFine) {
  const auto folder = real_data("lemur-pymatting");
  FLOATSTAGE_NEEDS_DATA(folder);
  const Still still = load(folder / "lemur.png", folder / "lemur_trimap.png", folder / "lemur_alpha_fba.png");
  ASSERT_FALSE(still.picture.empty());
  const double held = error(pyramid_matte(still.picture, still.trimap), still),
               alone = error(closed_form_matte(still.picture, still.trimap), still);
  std::cout << "lemur: from coarse to fine " << held << ", closed form " << alone << " (thousandths)\n";
  EXPECT_LE(held, alone);
}

}  // namespace
}  // namespace floatstage::matting
