#include <cstdlib>
#include <iostream>

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "matting/keyers/keyer.h"

// The keyers on the embedded studio, whose mattes are exact.
namespace floatstage::matting {
namespace {

struct Agreement {
  double mean_iou = 0;
  double edge_error = 0;  // mean |alpha - truth| / 255 over the pixels that the performer covers partly
};

Agreement agreement(const char* spec, const SyntheticStudioOptions& options) {
  const auto studio = SyntheticStudio::create(synthetic_rig({}), options);
  EXPECT_TRUE(studio) << studio.error().message;
  Agreement result;
  double partly = 0;
  constexpr int kCameras[] = {0, 3, 6};
  for (int camera : kCameras) {
    const SyntheticShot shot = studio->shoot(camera, 5 * camera);
    const bool needs_plate = std::string_view(spec) == "difference";
    const auto keyer = make_keyer(spec, {needs_plate ? studio->plate(camera) : *to_rgb(shot.frame)});
    EXPECT_TRUE(keyer) << keyer.error().message;
    const auto matte = (*keyer)->key(shot.frame);
    EXPECT_TRUE(matte) << matte.error().message;
    result.mean_iou += iou(*matte, shot.matte) / std::size(kCameras);
    for (int y = 0; y < matte->height; ++y) {
      for (int x = 0; x < matte->width; ++x) {
        const int truth = shot.matte.row(y)[x];
        if (truth == 0 || truth == 255) continue;
        result.edge_error += std::abs(matte->row(y)[x] - truth) / 255.0;
        partly += 1;
      }
    }
  }
  result.edge_error /= partly;
  std::cout << spec << ": mean IoU " << result.mean_iou << ", error of partly covered pixels "
            << result.edge_error << "\n";
  return result;
}

TEST(ChromaKeyerInTheStudio, FindsTheDancerWithHerLooseHair) {
  const Agreement a = agreement("chroma", {});
  EXPECT_GE(a.mean_iou, 0.984);
  EXPECT_LE(a.edge_error, 0.12);
}

TEST(ChromaKeyerInTheStudio, ToleratesNoiseSpillAndColourErrors) {
  SyntheticStudioOptions options;
  options.defects = {.noise = 3, .color_gain = 0.03, .green_spill = 0.3};
  const Agreement a = agreement("chroma", options);
  EXPECT_GE(a.mean_iou, 0.98);
  EXPECT_LE(a.edge_error, 0.14);
}

TEST(DifferenceKeyerInTheStudio, FindsTheDancerInFrontOfThePlate) {
  SyntheticStudioOptions options;
  options.defects = {.noise = 3};
  EXPECT_GE(agreement("difference", options).mean_iou, 0.965);
}

TEST(LuminanceKeyerInTheStudio, FindsTheDancerOnTheBlackStage) {
  SyntheticStudioOptions options;
  options.stage = SyntheticStage::Black;
  EXPECT_GE(agreement("luminance", options).mean_iou, 0.9);
}

TEST(ChromaKeyerInTheStudio, TakesTheSpillOffThePhotograph) {
  SyntheticStudioOptions spilled;
  spilled.defects.green_spill = 0.5;
  const auto studio = SyntheticStudio::create(synthetic_rig({}), spilled),
             clean = SyntheticStudio::create(synthetic_rig({}), {});
  ASSERT_TRUE(studio && clean);
  const SyntheticShot shot = studio->shoot(2, 0);
  const Image before = *to_rgb(shot.frame), truth = *to_rgb(clean->shoot(2, 0).frame);
  const auto keyer = make_keyer("chroma", {before});
  ASSERT_TRUE(keyer);
  const Image after = *(*keyer)->suppress_spill(shot.frame);
  double error_before = 0, error_after = 0;
  for (int y = 0; y < before.height; ++y) {
    for (int x = 0; x < before.width; ++x) {
      if (shot.matte.row(y)[x] < 255) continue;
      error_before += std::abs(before.at(x, y)[1] - truth.at(x, y)[1]);
      error_after += std::abs(after.at(x, y)[1] - truth.at(x, y)[1]);
    }
  }
  EXPECT_LT(error_after, 0.8 * error_before);
}

}  // namespace
}  // namespace floatstage::matting
