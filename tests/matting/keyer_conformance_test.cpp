#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

// What every keyer promises. A new keyer joins by its line in keyers(); if its stage is not green, by one in
// stage_for().
namespace floatstage::matting {
namespace {

Scene stage_for(const std::string& keyer) {
  Scene scene;
  scene.noise = 1.5;
  if (keyer == "luminance") scene.backing = {3, 3, 4};
  return scene;
}

class KeyerConformance : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Keyer> keyer() const {
    auto made = make_keyer(GetParam(), {empty_stage(stage_for(GetParam()))});
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }
  Scene scene() const { return stage_for(GetParam()); }
};

TEST_P(KeyerConformance, FindsTheSubjectToAPixel) {
  const auto matte = keyer()->key(make_frame({}, photograph(scene())));
  ASSERT_TRUE(matte) << matte.error().message;
  EXPECT_GE(iou(*matte, truth(scene())), 0.96);
}

TEST_P(KeyerConformance, GivesAMatteOfTheFramesSizeWithTheFramesFacts) {
  const FrameInfo info{.camera = 5, .sequence = 77, .exposure_start = {}, .exposure = {}, .device_time = {}};
  const auto matte = keyer()->key(make_frame(info, photograph(scene())));
  ASSERT_TRUE(matte);
  EXPECT_EQ(matte->width, 160);
  EXPECT_EQ(matte->height, 120);
  EXPECT_EQ(matte->source, info);
}

TEST_P(KeyerConformance, GivesAnEmptyMatteForACameraThatMissedTheInstant) {
  FrameInfo lost;
  lost.camera = 3;
  lost.status = FrameStatus::Lost;
  const auto matte = keyer()->key(Frame{lost, {}, nullptr});
  ASSERT_TRUE(matte);
  EXPECT_TRUE(matte->empty());
  EXPECT_EQ(matte->source, lost);
}

TEST_P(KeyerConformance, SeesNobodyOnTheEmptyStage) {
  const auto matte = keyer()->key(make_frame({}, empty_stage(scene(), 99)));
  ASSERT_TRUE(matte);
  EXPECT_EQ(to_image(*matte), Image(160, 120, 1, 0));
}

TEST_P(KeyerConformance, GivesSoftEdgesWhereTheSubjectCoversPixelsPartly) {
  const Image alpha = to_image(*keyer()->key(make_frame({}, photograph(scene()))));
  const auto soft =
      std::count_if(alpha.pixels.begin(), alpha.pixels.end(), [](int a) { return a > 0 && a < 255; });
  EXPECT_GT(soft, 20);
  EXPECT_LT(soft, 600);  // the disc's border is 190 px long
  EXPECT_EQ(*alpha.at(80, 60), 255);
}

TEST_P(KeyerConformance, GivesTheSameBytesOnManyThreadsAtOnce) {
  const auto shared = keyer();
  std::vector<Frame> frames;
  for (std::uint64_t seed = 0; seed < 8; ++seed) frames.push_back(make_frame({}, photograph(scene(), seed)));
  std::vector<Image> alone(frames.size()), together(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) alone[i] = to_image(*shared->key(frames[i]));
  parallel_for(frames.size(), 4, [&](std::size_t i) { together[i] = to_image(*shared->key(frames[i])); });
  EXPECT_EQ(alone, together);
}

TEST_P(KeyerConformance, IsMadeAgainFromItsSpec) {
  const auto first = keyer();
  auto second = make_keyer(first->spec(), {empty_stage(scene())});
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ((*second)->spec(), first->spec());
  EXPECT_THAT(first->spec(), ::testing::StartsWith(GetParam()));
  const Frame frame = make_frame({}, photograph(scene()));
  EXPECT_EQ(to_image(*(*second)->key(frame)), to_image(*first->key(frame)));
}

TEST_P(KeyerConformance, KeysAGreyFrameOrRefusesItWithASentenceThatNamesTheCamera) {
  FrameInfo info;
  info.camera = 4;
  const auto matte = keyer()->key(make_frame(info, Image(160, 120, 1, 90)));
  if (matte) {
    EXPECT_EQ(matte->width, 160);
  } else {
    EXPECT_EQ(matte.error().code, ErrorCode::Unsupported);
    EXPECT_THAT(matte.error().message, ::testing::HasSubstr("camera 4"));
  }
}

TEST_P(KeyerConformance, RefusesAFrameShorterThanItsLayout) {
  Frame cut = make_frame({}, photograph(scene()));
  cut.layout.size_bytes /= 2;
  const auto matte = keyer()->key(cut);
  ASSERT_FALSE(matte);
  EXPECT_EQ(matte.error().code, ErrorCode::BadData);
  EXPECT_FALSE(keyer()->suppress_spill(cut));
}

TEST_P(KeyerConformance, SuppressesSpillWithoutTouchingAColourFarFromTheBackings) {
  const auto clean = keyer()->suppress_spill(make_frame({}, Image(photograph(scene()))));
  ASSERT_TRUE(clean);
  const Image before = photograph(scene());
  ASSERT_EQ(clean->channels, 3);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(clean->at(80, 60)[c], before.at(80, 60)[c]);
}

TEST_P(KeyerConformance, SurvivesAOnePixelFrame) {
  // The plate has another size: the difference keyer must say so, the others must key it.
  const auto matte = keyer()->key(make_frame({}, Image(1, 1, 3, 200)));
  if (matte) {
    EXPECT_EQ(to_image(*matte), Image(1, 1, 1, 255));
  } else {
    EXPECT_EQ(matte.error().code, ErrorCode::InvalidArgument);
  }
}

TEST_P(KeyerConformance, RefusesSamplesThatAreNoPicture) {
  Image broken(10, 10, 3);
  broken.pixels.resize(7);
  const auto made = make_keyer(GetParam(), {broken});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
}

TEST_P(KeyerConformance, RefusesANonsensicalParameter) {
  for (const char* parameter : {":", ":abc", ":-3", ":12px", ":999", ":#12", ":#gg0000"}) {
    const auto made = make_keyer(GetParam() + parameter, {empty_stage(scene())});
    ASSERT_FALSE(made) << parameter;
    EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
    EXPECT_THAT(made.error().message, ::testing::HasSubstr(GetParam())) << "the sentence shows a good one";
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const KeyerInfo& info : keyers()) all.push_back(info.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(AllKeyers, KeyerConformance, ::testing::ValuesIn(names()),
                         [](const auto& suite) { return suite.param; });

TEST(Keyers, EachHasALineOfHelpThatStartsWithItsName) {
  ASSERT_GE(keyers().size(), 3u);
  for (const KeyerInfo& info : keyers()) EXPECT_THAT(info.help, ::testing::StartsWith(info.name));
}

TEST(Keyers, AnUnknownNameIsAnsweredWithTheList) {
  for (const char* spec : {"", "magic", "chroma2", ":12"}) {
    const auto made = make_keyer(spec, {});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
    for (const KeyerInfo& info : keyers()) EXPECT_THAT(made.error().message, ::testing::HasSubstr(info.name));
  }
}

}  // namespace
}  // namespace floatstage::matting
