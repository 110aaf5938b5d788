#include "matting/keyers/added_frame.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/added_search.h"
#include "matting/keyers/keyer.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

AddedContent bars_of(const std::vector<Image>& pictures) { return added_bars(pictures); }

Image framed(const Image& picture, const AddedContent& frame, std::uint8_t grey = 0) {
  Image out(picture.width + frame.left + frame.right, picture.height + frame.top + frame.bottom, 3, grey);
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.at(0, y), 3 * picture.width, out.at(frame.left, frame.top + y));
  return out;
}

TEST(AddedFrame, IsFoundOnEverySideToThePixel) {
  const Image picture = photograph({.noise = 1});
  EXPECT_TRUE(bars_of({picture}).none());
  for (const AddedContent& frame :
       {AddedContent{.top = 12, .bottom = 12}, AddedContent{.left = 20, .right = 3}, AddedContent{.left = 1},
        AddedContent{4, 5, 6, 7}}) {
    EXPECT_EQ(bars_of({framed(picture, frame)}), frame);
    EXPECT_EQ(bars_of({framed(picture, frame, 235)}), frame) << "white bars";
    EXPECT_EQ(inside(framed(picture, frame), frame), picture);
  }
}

TEST(AddedFrame, IsWhatAllPicturesShow) {
  const Image picture = photograph({.noise = 1});
  const Image boxed = framed(picture, {.top = 12, .bottom = 12}),
              less = framed(photograph({.height = 124, .noise = 1}), {.top = 12, .bottom = 8});
  EXPECT_EQ(bars_of({boxed, less}), (AddedContent{.top = 12, .bottom = 8}));
  EXPECT_TRUE(bars_of({boxed, picture, photograph({.height = 144, .noise = 1})}).none());
}

TEST(AddedFrame, IsNotAStagesOwnBlack) {
  EXPECT_TRUE(bars_of({photograph({.backing = {0, 0, 0}, .subject = {200, 180, 160}})}).none());
  EXPECT_TRUE(bars_of({Image(160, 120, 3, 0)}).none()) << "nothing inside";
  EXPECT_TRUE(bars_of({}).none());
  EXPECT_TRUE(bars_of({Image(1, 1, 3, 9)}).none());
}

// A sky that is even to the step, and hedges and a head before it: two hedges end at the same height.
TEST(AddedFrame, IsNoSkyBehindThingsOfDifferentHeights) {
  Image garden = photograph({.noise = 1});
  const auto sky_above = [&](int from, int to, int horizon) {
    for (int x = from; x < to; ++x)
      for (int y = 0; y < horizon; ++y) std::fill_n(garden.at(x, y), 3, std::uint8_t{200});
  };
  sky_above(0, 40, 24);
  sky_above(40, 100, 40);
  sky_above(100, 130, 12);  // a head
  sky_above(130, 150, 24);
  sky_above(150, garden.width, 34);
  EXPECT_TRUE(bars_of({garden}).none());
}

// A sky that is even to the step, above a wall that is level: its end is as straight as a bar's.
TEST(AddedFrame, IsNoSkyThatAHeadReachesInto) {
  EXPECT_TRUE(bars_of({framed(photograph({.noise = 1}), {.top = 24}, 255)}).none()) << "overexposed";
  Image blue = framed(photograph({.noise = 1}), {.top = 24}, 120);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < blue.width; ++x) blue.at(x, y)[2] = 200;
  EXPECT_TRUE(bars_of({blue}).none());
  Image yard = framed(photograph({.noise = 1}), {.top = 24}, 200);
  EXPECT_EQ(bars_of({yard}), (AddedContent{.top = 24}));
  const Image before = yard;
  for (int y = 10; y < 24; ++y)
    for (int x = 60; x < 72; ++x) std::fill_n(yard.at(x, y), 3, std::uint8_t{60});
  EXPECT_TRUE(bars_of({yard}).none());
  EXPECT_TRUE(bars_of({before, yard}).none()) << "in one of two pictures";
}

TEST(AddedFrame, MayBeWrittenOn) {
  Image boxed = framed(photograph({.noise = 1}), {.top = 16});
  for (int y = 4; y < 11; ++y)
    for (int x = 20; x < 50; x += 4) std::fill_n(boxed.at(x, y), 3, std::uint8_t{250});
  EXPECT_EQ(bars_of({boxed}), (AddedContent{.top = 16}));
}

TEST(AddedFrame, IsBackgroundToAKeyerThatSeesTheRestAsWithoutIt) {
  const AddedContent frame{.left = 9, .top = 14, .right = 9, .bottom = 14};
  for (const char* spec : {"chroma", "luminance"}) {
    Scene scene{.noise = 1.5};
    if (std::string_view(spec) == "luminance") scene.backing = {14, 14, 16};
    const Image plain = photograph(scene), boxed = framed(plain, frame, 0);
    const auto alone = make_keyer(spec, {plain}), keyer = make_keyer(spec, {boxed});
    ASSERT_TRUE(alone && keyer) << spec;
    const auto expected = (*alone)->key(make_frame({}, plain)), matte = (*keyer)->key(make_frame({}, boxed));
    ASSERT_TRUE(expected && matte) << spec;
    EXPECT_EQ(inside(to_image(*matte), frame), to_image(*expected)) << spec;
    EXPECT_NEAR(coverage(*matte) * matte->width * matte->height,
                coverage(*expected) * expected->width * expected->height, 0.5)
        << spec << ": the frame is subject";
  }
}

// White digits in a corner, as recorders burn them in: too small to be a performer.
TEST(ATimeStampBurntIn, IsNoSubject) {
  for (const char* spec : {"chroma", "luminance"}) {
    Scene scene{.width = 320, .height = 240, .radius = 60, .noise = 1.5};
    if (std::string_view(spec) == "luminance") scene.backing = {3, 3, 4};
    Image picture = photograph(scene);
    for (int digit = 0; digit < 8; ++digit)
      for (int y = 0; y < 7; ++y)
        for (const int x : {0, 3})
          for (int c = 0; c < 3; ++c) picture.at(230 + 9 * digit + x, 228 + y)[c] = 250;
    const auto keyer = make_keyer(spec, {picture});
    ASSERT_TRUE(keyer) << spec;
    const auto matte = (*keyer)->key(make_frame({}, picture));
    ASSERT_TRUE(matte) << spec << ": " << matte.error().message;
    EXPECT_GE(iou(*matte, truth(scene)), 0.97) << spec;
    for (int y = 222; y < 240; ++y)
      for (int x = 226; x < 306; ++x) EXPECT_LT(matte->row(y)[x], 128) << spec << " " << x << " " << y;
  }
}

}  // namespace
}  // namespace floatstage::matting
