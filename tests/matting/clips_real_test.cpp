#include <iostream>

#include "core/png.h"
#include "matting/closed_form.h"
#include "matting/keyers/keyer.h"
#include "matting/method_selection.h"
#include "matting/video/closed_form_video.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/real_data.h"

// A furry animal that moves and turns; its matte is known in the first frame only.
namespace floatstage::matting {
namespace {

Image rgb_of(const Image& picture) {
  if (picture.channels == 3) return picture;
  Image out(picture.width, picture.height, 3);
  for (std::size_t p = 0; p < out.pixels.size() / 3; ++p)
    std::copy_n(picture.pixels.data() + 4 * p, 3, out.pixels.data() + 3 * p);
  return out;
}

class Lemur : public testing::TestWithParam<std::uint64_t> {
 protected:
  void SetUp() override {
    FLOATSTAGE_NEEDS_DATA(folder());
    cutout_ = {rgb_of(*load_png(folder() / "lemur_foreground.png")), *load_png(folder() / "lemur_alpha.png")};
  }
  static std::filesystem::path folder() { return real_data("lemur-pymatting"); }
  MatteClip clip(const Image& backdrop) const {
    return make_clip(cutout_, backdrop, {.seed = GetParam(), .scale = 0.4});
  }
  static ClipScores carried(const MatteClip& clip) {
    Result<ClosedFormVideo> video = ClosedFormVideo::create();
    EXPECT_THAT(video->keyframe(clip.frames[0], clip.truth[0]), IsOk());
    std::vector<Image> mattes = {clip.truth[0]};
    for (std::size_t f = 1; f < clip.frames.size(); ++f) mattes.push_back(*video->next(clip.frames[f]));
    return score_clip(mattes, clip.truth);
  }
  Cutout cutout_;
};

TEST_P(Lemur, IsCarriedOverGreenClothFromTheFirstFrame) {
  const ClipScores s = carried(clip(green_cloth(360, 240, GetParam())));
  std::cout << "lemur, green cloth, seed " << GetParam() << ": " << s << "\n";
  EXPECT_LE(s.mse, 3.1e-3);
  EXPECT_LE(s.dtssd, 4.9e-2);
  EXPECT_GE(s.iou, 0.956);
}

TEST_P(Lemur, IsCarriedOverTheBeachFromTheFirstFrame) {
  const Image beach = rgb_of(*load_png(folder() / "beach.png"));
  Image plate(360, 240, 3);  // a window of the beach, at half its size where it is large enough
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 360; ++x)
      std::copy_n(beach.at(x * beach.width / 360, y * beach.height / 240), 3, plate.at(x, y));
  const ClipScores s = carried(clip(plate));
  std::cout << "lemur, beach, seed " << GetParam() << ": " << s << "\n";
  EXPECT_LE(s.mse, 8.8e-3);
  EXPECT_GE(s.iou, 0.93);
}

// What `auto` chooses by: the truth agrees with it.
TEST_P(Lemur, IsMattedBestByWhatExplainsThePictureBest) {
  for (const bool green : {true, false}) {
    const MatteClip c =
        clip(green ? green_cloth(360, 240, GetParam()) : cluttered_place(360, 240, GetParam()));
    const auto keyer = green ? make_keyer("chroma", {c.frames[0]}) : make_keyer("plate", {c.plate});
    const Plate plate = *learn_plate({c.plate});
    for (std::size_t f = 0; f < c.frames.size(); f += 4) {
      const Image key = to_image(*(*keyer)->key(make_frame({}, c.frames[f])));
      const Image refined = *refine_matte(c.frames[f], key, key_refinement());
      const std::vector<double> r =
          composite_residuals(c.frames[f], {key, refined}, green ? nullptr : &plate);
      EXPECT_EQ(r[1] < r[0], pipeline::matte_mse(refined, c.truth[f]) < pipeline::matte_mse(key, c.truth[f]))
          << green << " frame " << f;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Lemur, testing::Values(1, 2, 3));

}  // namespace
}  // namespace floatstage::matting
