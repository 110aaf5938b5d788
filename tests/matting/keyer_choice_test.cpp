#include "matting/keyers/keyer_choice.h"

#include <gmock/gmock.h>

#include "core/synthetic/synthetic_studio.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

using testing::ElementsAre;

// A camera of a stage: its clean plate, or a photograph of the performer.
KeySamples seen(SyntheticStage stage, bool plate) {
  const Rig rig = synthetic_rig({.cameras = 4, .width = 160, .height = 120});
  const SyntheticStudio studio = *SyntheticStudio::create(rig, {.samples = 4, .stage = stage});
  return {{plate ? studio.plate(0) : *to_rgb(studio.shoot(0, 0).frame)}, plate};
}

std::string chosen(const KeySamples& samples) { return choose_keyers({samples}).front(); }

TEST(ChooseKeyers, TakesClothThenTheCleanPlateThenABlackStage) {
  EXPECT_EQ(chosen(seen(SyntheticStage::Green, true)), "chroma");
  EXPECT_EQ(chosen(seen(SyntheticStage::Green, false)), "chroma");
  EXPECT_EQ(chosen(seen(SyntheticStage::Room, true)), "plate");
  EXPECT_EQ(chosen(seen(SyntheticStage::Black, true)), "plate");
  EXPECT_EQ(chosen(seen(SyntheticStage::Black, false)), "luminance");
}

TEST(ChooseKeyers, HasNothingForARoomThatNobodyPhotographedEmpty) {
  EXPECT_EQ(chosen(seen(SyntheticStage::Room, false)), "");
  EXPECT_EQ(chosen({}), "");
}

// Nothing stands out there, so that only its own brightness tells.
TEST(ChooseKeyers, KnowsABlackStageWithoutAnybody) {
  KeySamples empty = seen(SyntheticStage::Black, true);
  empty.empty_stage = false;  // it is the first picture that came
  EXPECT_EQ(chosen(empty), "luminance");
  EXPECT_EQ(chosen({{Image(160, 120, 3, 200)}, false}), "");
}

TEST(ChooseKeyers, TakesThePlatesOfAllWhereOnlySomeHaveClothBeforeThem) {
  const KeySamples cloth = seen(SyntheticStage::Green, true), room = seen(SyntheticStage::Room, true);
  EXPECT_THAT(choose_keyers({cloth, room}), ElementsAre("plate", "plate"));
  KeySamples photograph = seen(SyntheticStage::Green, false);
  EXPECT_THAT(choose_keyers({photograph, room}), ElementsAre("chroma", "plate")) << "which has no plate";
}

}  // namespace
}  // namespace floatstage::matting
