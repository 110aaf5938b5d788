#include <set>

#include <gtest/gtest.h>

#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

SyntheticStudio on(SyntheticStage stage) {
  SyntheticStudioOptions options = quick_options();
  options.stage = stage;
  return studio_with(small_rig(), options);
}

TEST(SyntheticStages, HaveNamesThatLeadBackToThem) {
  std::set<std::string_view> names;
  for (const SyntheticStageName& s : synthetic_stages()) {
    EXPECT_EQ(synthetic_stage(s.name), s.stage);
    names.insert(s.name);
  }
  EXPECT_EQ(names.size(), synthetic_stages().size());
  EXPECT_FALSE(synthetic_stage("purple"));
}

TEST(SyntheticStages, ShareOneTruthAndDifferInWhatStandsBehind) {
  const Image truth = to_image(on(SyntheticStage::Green).shoot(0, 3).matte);
  std::set<std::vector<std::uint8_t>> plates;
  for (const SyntheticStageName& s : synthetic_stages()) {
    const SyntheticStudio studio = on(s.stage);
    EXPECT_EQ(to_image(studio.shoot(0, 3).matte), truth) << s.name;
    plates.insert(studio.plate(0).pixels);
  }
  EXPECT_EQ(plates.size(), synthetic_stages().size() - 1) << "green and green-clothes share the cloth";
}

TEST(SyntheticStages, DressThePerformerInTheClothsColourOnlyWhereAsked) {
  const Image usual = *to_rgb(on(SyntheticStage::Green).shoot(0, 0).frame),
              dressed = *to_rgb(on(SyntheticStage::GreenClothes).shoot(0, 0).frame);
  const Matte matte = on(SyntheticStage::Green).shoot(0, 0).matte;
  int changed = 0, same = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      const bool equal = std::equal(usual.at(x, y), usual.at(x, y) + 3, dressed.at(x, y));
      if (matte.row(y)[x] == 0) {
        EXPECT_TRUE(equal) << x << " " << y;
      } else {
        ++(equal ? same : changed);
      }
    }
  EXPECT_GT(changed, 0.03 * same);
  EXPECT_LT(changed, same);
}

}  // namespace
}  // namespace floatstage
