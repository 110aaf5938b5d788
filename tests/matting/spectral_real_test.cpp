#include <cmath>
#include <cstdlib>
#include <iostream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/png.h"
#include "matting/spectral/spectral_matting.h"
#include "tests/matting/spectral_clips.h"
#include "tests/support/long_tests.h"
#include "tests/support/real_data.h"

namespace floatstage::matting {
namespace {

Image rgb_of(const Image& picture) {
  Image out(picture.width, picture.height, 3);
  for (std::size_t p = 0; p < out.pixels.size() / 3; ++p)
    std::copy_n(picture.pixels.data() + picture.channels * p, 3, out.pixels.data() + 3 * p);
  return out;
}

Image halved(const Image& picture) {
  Image out(picture.width / 2, picture.height / 2, picture.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < out.channels; ++c)
        out.at(x, y)[c] = static_cast<std::uint8_t>(
            (picture.at(2 * x, 2 * y)[c] + picture.at(2 * x + 1, 2 * y)[c] + picture.at(2 * x, 2 * y + 1)[c] +
             picture.at(2 * x + 1, 2 * y + 1)[c] + 2) /
            4);
  return out;
}

class SpectralLemur : public testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override { FLOATSTAGE_NEEDS_DATA(folder()); }
  static std::filesystem::path folder() { return real_data("lemur-pymatting"); }
  static Image load(const char* name) { return *load_png(folder() / name); }
};

TEST_P(SpectralLemur, IsFollowedOverGreenClothFromTheFirstFrame) {
  FLOATSTAGE_LONG_FORM(GetParam() != 1);
  const Cutout cutout{rgb_of(load("lemur_foreground.png")), load("lemur_alpha.png")};
  const MatteClip clip =
      make_clip(cutout, green_cloth(360, 240, GetParam()), {.seed = GetParam(), .scale = 0.4});
  const SpectralResult result = spectral_mattes(clip);
  const ClipScores s = score_clip(result.mattes, clip.truth);
  std::cout << "lemur, green cloth, seed " << GetParam() << ": " << s << ", " << result.fitting
            << " frames fit\n";
  EXPECT_LE(s.mse, 3.1e-3);
  EXPECT_LE(s.dtssd, 4.9e-2);
  EXPECT_GE(s.iou, 0.956);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SpectralLemur, testing::Values(1, 2, 3));

TEST(SpectralMattingOfTheLemur, HasItAmongItsComponentsAsWellAsWithExactEigenvectors) {
  const auto folder = real_data("lemur-pymatting");
  FLOATSTAGE_NEEDS_DATA(folder);
  const Image picture = halved(rgb_of(*load_png(folder / "lemur.png"))),
              truth = halved(*load_png(folder / "lemur_alpha.png"));
  auto solver = EigenSolver::create(picture.width, picture.height);
  ASSERT_THAT(solver, IsOk());
  const auto pairs = solver->solve(picture);
  ASSERT_THAT(pairs, IsOk());
  EXPECT_LE(pairs->residual, 1e-5);
  const auto components = matting_components(*pairs);
  ASSERT_THAT(components, IsOk());
  const auto chosen = select_components(*components, {{{truth, {}}, 1}});
  ASSERT_THAT(chosen, IsOk());
  // What a prototype with exact eigenvectors reached: a sum of absolute differences of 5.6 thousand.
  const Image matte = matte_of(*components, chosen->chosen);
  double sum = 0;
  for (std::size_t p = 0; p < matte.pixels.size(); ++p)
    sum += std::abs(matte.pixels[p] - truth.pixels[p]) / 255.0;
  std::cout << "best subset of 10 components: SAD " << sum << ", residual " << pairs->residual << "\n";
  EXPECT_LE(sum, 6000);
}

}  // namespace
}  // namespace floatstage::matting
