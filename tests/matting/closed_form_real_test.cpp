#include <cmath>
#include <iostream>

#include "core/png.h"
#include "matting/closed_form.h"
#include "matting/foreground.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

// Against Levin's Matlab code on his own picture.
namespace floatstage::matting {
namespace {

class Dandelion : public testing::Test {
 protected:
  Image load(const char* name) const {
    Result<Image> image = load_png(real_data("levin-dandelion") / name);
    EXPECT_THAT(image, IsOk());
    return image ? std::move(*image) : Image();
  }
  void expect_matlabs_alpha(const Image& trimap) const {
    const Result<Image> solved = closed_form_matte(load("source.png"), trimap);
    ASSERT_THAT(solved, IsOk());
    const Image matlab = load("matlab_alpha.png");
    int worst = 0;
    double sum = 0;
    for (std::size_t i = 0; i < matlab.pixels.size(); ++i) {
      const int d = std::abs(solved->pixels[i] - matlab.pixels[i]);
      worst = std::max(worst, d);
      sum += d / 255.0;
    }
    const double mean = sum / static_cast<double>(matlab.pixels.size());
    std::cout << "against Matlab: largest difference " << worst << "/255, mean " << mean << "\n";
    EXPECT_LE(worst, 2);
    EXPECT_LE(mean, 1e-4);
  }
};

TEST_F(Dandelion, IsMattedAsByMatlabFromATrimap) {
  FLOATSTAGE_NEEDS_DATA(real_data("levin-dandelion"));
  Image trimap = load("trimap.png");
  expect_matlabs_alpha(trimap);
}

TEST_F(Dandelion, IsMattedAsByMatlabFromScribbles) {
  FLOATSTAGE_NEEDS_DATA(real_data("levin-dandelion"));
  const Result<Image> trimap = trimap_from_scribbles(load("source.png"), load("scribbles.png"));
  ASSERT_THAT(trimap, IsOk());
  expect_matlabs_alpha(*trimap);
}

TEST_F(Dandelion, HasTheForegroundColoursThatMatlabFinds) {
  FLOATSTAGE_NEEDS_DATA(real_data("levin-dandelion"));
  const Image alpha = load("matlab_alpha.png"), matlab = load("matlab_foreground.png"),
              source = load("source.png");
  const Result<Layers> layers = estimate_foreground(source, alpha);
  ASSERT_THAT(layers, IsOk());
  double ours = 0, naive = 0, weight = 0;
  for (std::size_t p = 0; p < alpha.pixels.size(); ++p) {
    const double a = alpha.pixels[p] / 255.0;  // a colour matters as much as it shows
    for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) {
      ours += a * std::abs(layers->foreground.pixels[c] - matlab.pixels[c]);
      naive += a * std::abs(source.pixels[c] - matlab.pixels[c]);
      weight += a;
    }
  }
  std::cout << "foreground: mean difference " << ours / weight << " of 255, of the photograph itself "
            << naive / weight << "\n";
  EXPECT_LE(ours, 0.5 * naive);
}

}  // namespace
}  // namespace floatstage::matting
