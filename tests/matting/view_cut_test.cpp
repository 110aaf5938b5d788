#include "matting/view_cut.h"

#include <algorithm>

#include "matting/view_colors.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

constexpr int kW = 64, kH = 48;

bool in_disc(int x, int y) { return (x - 32) * (x - 32) + (y - 24) * (y - 24) < 144; }

// A disc before cloth that is lit from one side, in colours `subject` and a quarter to all of `cloth`.
Image disc_before_cloth(std::array<int, 3> subject, std::array<int, 3> cloth) {
  Image picture(kW, kH, 3);
  for (int y = 0; y < kH; ++y)
    for (int x = 0; x < kW; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        picture.at(x, y)[c] =
            static_cast<std::uint8_t>(in_disc(x, y) ? subject[c] : cloth[c] * (kW + 3 * x) / (4 * kW));
  return picture;
}

std::vector<float> shares_of_disc() {
  std::vector<float> shares;
  for (int y = 0; y < kH; ++y)
    for (int x = 0; x < kW; ++x) shares.push_back(in_disc(x, y) ? 1.0f : 0.0f);
  return shares;
}

TEST(ViewCut, LitClothLiesNearTheBorderAndWhatEdgesEncloseFarFromIt) {
  const std::vector<float> edges = edges_to_border(disc_before_cloth({200, 60, 50}, {40, 160, 60}));
  float most_outside = 0, least_inside = 1e9f;
  for (int y = 0; y < kH; ++y)
    for (int x = 0; x < kW; ++x) {
      const float e = edges[static_cast<std::size_t>(y) * kW + static_cast<std::size_t>(x)];
      (in_disc(x, y) ? least_inside : most_outside) =
          in_disc(x, y) ? std::min(least_inside, e) : std::max(most_outside, e);
    }
  EXPECT_LT(most_outside, 0.1f * least_inside);
}

TEST(ViewCut, DarkHairBeforeADarkWallCountsAsMuchAsItsRatio) {
  const auto inside = [](const Image& picture) {
    return edges_to_border(picture)[static_cast<std::size_t>(24) * kW + 32];
  };
  const float dark = inside(disc_before_cloth({24, 21, 19}, {12, 12, 12})),
              bright = inside(disc_before_cloth({240, 210, 190}, {120, 120, 120}));
  EXPECT_GT(dark, 0.3f * bright);
}

TEST(ViewCut, FollowsTheOddsWhereColoursAgreeAndTheEdgeWhereOddsAreBlunt) {
  const Image picture = disc_before_cloth({200, 60, 50}, {40, 160, 60});
  std::vector<float> odds;
  for (int y = 0; y < kH; ++y)
    for (int x = 0; x < kW; ++x)
      odds.push_back(std::abs(x - 32) + std::abs(y - 24) < 6 ? 1.0f : in_disc(x, y) ? 0.05f : -0.05f);
  const Image cut = cut_view(picture, odds, {}, 3);
  int wrong = 0;
  for (int y = 0; y < kH; ++y)
    for (int x = 0; x < kW; ++x) wrong += (*cut.at(x, y) == 255) != in_disc(x, y);
  EXPECT_EQ(wrong, 0);
}

// An arm two pixels wide, hardly darker than the wall, with a shelf's edge two pixels above it.
TEST(ViewCut, EdgesOfTheEmptyStageAreNoneAndSkinBeforeAWallOfItsColourHasSome) {
  Image stage(kW, kH, 3, 150);
  for (int x = 0; x < kW; ++x) std::fill_n(stage.at(x, 0), 3 * 20, std::uint8_t{150});
  for (int y = 0; y < 20; ++y) std::fill_n(stage.at(0, y), 3 * kW, std::uint8_t{40});
  Image picture = stage, alone(kW, kH, 1);
  std::vector<float> odds(static_cast<std::size_t>(kW) * kH, -0.6f);
  for (int y = 22; y < 24; ++y)
    for (int x = 0; x < 40; ++x) {
      std::fill_n(picture.at(x, y), 3, std::uint8_t{138});
      *alone.at(x, y) = 255;
      odds[static_cast<std::size_t>(y) * kW + static_cast<std::size_t>(x)] = 3;
    }
  EXPECT_TRUE(cut_view(picture, odds, {}, 3, stage) == alone);
  EXPECT_FALSE(cut_view(picture, odds, {}, 3) == alone);
}

// A leg in front of the shadow that it casts, hardly darker: the stage is supposed to look like both.
TEST(ViewCut, EdgesInAShadowAreThePictures) {
  Image picture(kW, kH, 3, 90), leg(kW, kH, 1);
  std::vector<float> odds(static_cast<std::size_t>(kW) * kH, -0.3f);
  for (int y = 0; y < 30; ++y)
    for (int x = 20; x < 24; ++x) {
      std::fill_n(picture.at(x, y), 3, std::uint8_t{78});
      *leg.at(x, y) = 255;
      odds[static_cast<std::size_t>(y) * kW + static_cast<std::size_t>(x)] = y < 8 ? 3.0f : 0.3f;
    }
  const std::vector<std::uint8_t> shadow(odds.size(), 255);
  EXPECT_TRUE(cut_view(picture, odds, {}, 3, picture, shadow) == leg);
  EXPECT_FALSE(cut_view(picture, odds, {}, 3, picture) == leg);
}

TEST(ViewCut, WhatIsCertainOutranksTheOdds) {
  const Image picture(8, 8, 3, 100);
  std::vector<Certain> certain(64, Certain::No);
  certain[0] = Certain::Subject;
  certain[63] = Certain::Backdrop;
  const Image cut = cut_view(picture, std::vector<float>(64, -0.5f), certain, 0);
  EXPECT_EQ(cut.pixels[0], 255);
  EXPECT_EQ(cut.pixels[1], 0);
  EXPECT_EQ(cut_view(picture, std::vector<float>(64, 0.5f), certain, 0).pixels[63], 0);
}

TEST(ViewColors, TellSubjectFromBackdropAndBorrowFromOtherCameras) {
  const std::vector<Image> pictures = {disc_before_cloth({200, 60, 50}, {40, 160, 60}),
                                       disc_before_cloth({200, 60, 50}, {60, 60, 160})};
  // Nobody has found the subject in the second camera yet.
  std::vector<std::vector<float>> shares = {shares_of_disc(), shares_of_disc()};
  for (float& s : shares[1]) s = s > 0 ? -1.0f : 0.0f;
  const ViewColors colors(pictures, shares, 0.05, 1);
  for (const int camera : {0, 1}) {
    const std::vector<float> odds = colors.odds(camera, pictures[static_cast<std::size_t>(camera)]);
    EXPECT_GT(odds[static_cast<std::size_t>(24) * kW + 32], 2) << camera;
    EXPECT_LT(odds[static_cast<std::size_t>(4) * kW + 60], -2) << camera;
  }
}

TEST(ViewColors, WhatTheBackdropNeverShowedIsRatherSubjectAsLongAsNoveltyIsLikely) {
  const std::vector<Image> pictures = {disc_before_cloth({200, 60, 50}, {40, 160, 60})};
  const std::vector<std::vector<float>> shares = {shares_of_disc()};
  const Image unseen(1, 1, 3, 230);
  EXPECT_GT(ViewColors(pictures, shares, 0.2, 1).odds(0, unseen)[0], 1);
}

TEST(ViewColors, AreTheSameAtAnyNumberOfThreads) {
  const std::vector<Image> pictures(5, disc_before_cloth({200, 60, 50}, {40, 160, 60}));
  const std::vector<std::vector<float>> shares(5, shares_of_disc());
  EXPECT_EQ(ViewColors(pictures, shares, 0.1, 1).odds(3, pictures[3]),
            ViewColors(pictures, shares, 0.1, 4).odds(3, pictures[3]));
}

}  // namespace
}  // namespace floatstage::matting
