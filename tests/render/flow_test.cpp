#include "render/flow.h"

#include <cmath>

#include "render/image_fill.h"
#include "render/pairwise_flows.h"
#include "tests/support/matchers.h"

namespace floatstage::render {
namespace {

using testing::HasSubstr;

/// A smooth texture, displaced.
std::vector<std::uint8_t> texture(int width, int height, double dx, double dy) {
  std::vector<std::uint8_t> gray;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = x - dx, v = y - dy;
      gray.push_back(static_cast<std::uint8_t>(128 + 50 * std::sin(u * 0.31) * std::cos(v * 0.23) +
                                               50 * std::sin(0.13 * u + 0.19 * v)));
    }
  return gray;
}

class FlowBackend : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<render::FlowEstimator> make() {
    render::FlowOptions options;
    options.backend = GetParam();
    auto made = render::make_flow_estimator(options);
    EXPECT_THAT(made, IsOk());
    return std::move(*made);
  }
};
INSTANTIATE_TEST_SUITE_P(Conformance, FlowBackend, testing::ValuesIn(render::flow_backends()),
                         [](const auto& param) { return param.param; });

TEST_P(FlowBackend, FindsADisplacementWithItsSign) {
  const auto first = texture(160, 120, 0, 0), second = texture(160, 120, 3.5, -2);
  const auto flow = estimate_flow(*make(), {160, 120, first.data()}, {160, 120, second.data()});
  ASSERT_THAT(flow, IsOk());
  for (int y = 30; y < 90; y += 5)
    for (int x = 30; x < 130; x += 5) {
      EXPECT_NEAR(flow->uv[2 * (static_cast<std::size_t>(y) * 160 + static_cast<std::size_t>(x))], 3.5, 0.3);
      EXPECT_NEAR(flow->uv[2 * (static_cast<std::size_t>(y) * 160 + static_cast<std::size_t>(x)) + 1], -2,
                  0.3);
    }
}

TEST_P(FlowBackend, EqualPicturesDoNotMove) {
  const auto picture = texture(96, 80, 0, 0);
  const auto flow = estimate_flow(*make(), {96, 80, picture.data()}, {96, 80, picture.data()});
  ASSERT_THAT(flow, IsOk());
  EXPECT_THAT(flow->uv, testing::Each(0.F));
}

TEST_P(FlowBackend, TakesPicturesOfAnySize) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 200), std::pair(65, 33)}) {
    const auto first = texture(width, height, 0, 0), second = texture(width, height, 1, 0);
    const auto flow = estimate_flow(*make(), {width, height, first.data()}, {width, height, second.data()});
    ASSERT_THAT(flow, IsOk());
    EXPECT_EQ(flow->width, width);
    EXPECT_EQ(flow->uv.size(), static_cast<std::size_t>(2 * width * height));
    for (float v : flow->uv) ASSERT_TRUE(std::isfinite(v));
  }
}

TEST_P(FlowBackend, RefusesPicturesOfDifferentSizes) {
  const auto picture = texture(96, 80, 0, 0);
  EXPECT_THAT(estimate_flow(*make(), {96, 80, picture.data()}, {80, 96, picture.data()}),
              FailsWith(ErrorCode::InvalidArgument, "different sizes"));
}

TEST(Flow, RefusesUnknownNamesAndNumbers) {
  render::FlowOptions options;
  options.backend = "guess";
  EXPECT_THAT(render::make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "'guess'"));
  options = {};
  options.preset = "slow";
  EXPECT_THAT(render::make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "'slow'"));
  options = {};
  options.finest_scale = -1;
  EXPECT_THAT(render::make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "finest scale"));
  for (const int warps : {-1, 99}) {
    options = {};
    options.iterations = warps;
    EXPECT_THAT(render::make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "warps"));
  }
}

TEST(PictureFill, KeepsWhatIsKnownAndContinuesItSmoothly) {
  constexpr int kWidth = 33, kHeight = 20;
  std::vector<float> values(kWidth * kHeight, -1000);
  std::vector<std::uint8_t> known(kWidth * kHeight, 0);
  for (int y = 0; y < kHeight; ++y)
    for (int x : {0, 1, 31, 32}) {
      known[static_cast<std::size_t>(y * kWidth + x)] = 255;
      values[static_cast<std::size_t>(y * kWidth + x)] = x < 5 ? 10 : 20;
    }
  PictureFill().run(kWidth, kHeight, 1, known.data(), values.data());
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const float v = values[static_cast<std::size_t>(i)];
    if (known[static_cast<std::size_t>(i)]) {
      EXPECT_EQ(v, i % kWidth < 5 ? 10 : 20);
    }
    EXPECT_GE(v, 10);
    EXPECT_LE(v, 20);
  }
  EXPECT_NEAR(values[10 * kWidth + 16], 15, 2);
}

TEST(PictureFill, GivesTheSameWhenItsMemoryIsUsedAgain) {
  PictureFill used;
  for (const auto& [width, height] :
       {std::pair(33, 20), std::pair(7, 41), std::pair(1, 1), std::pair(32, 5)}) {
    std::vector<float> values;
    std::vector<std::uint8_t> known;
    for (int i = 0; i < width * height; ++i) {
      known.push_back(i % 7 == 3 ? 200 : 0);
      values.push_back(static_cast<float>(i % 13));
      values.push_back(static_cast<float>(i % 5));
    }
    std::vector<float> again = values;
    PictureFill().run(width, height, 2, known.data(), values.data());
    used.run(width, height, 2, known.data(), again.data());
    EXPECT_EQ(values, again) << width << "x" << height;
  }
}

TEST(PictureFill, NothingKnownIsZero) {
  std::vector<float> values(30, 7);
  PictureFill().run(3, 5, 2, std::vector<std::uint8_t>(15, 0).data(), values.data());
  EXPECT_THAT(values, testing::Each(0.F));
}

ProjectedImages two_images(double dx) {
  const std::vector<std::uint8_t> own(160 * 120, ProjectedImages::kOwn);
  return {160, 120, {texture(160, 120, 0, 0), texture(160, 120, dx, 0)}, {own, own}};
}

TEST(FlowTrust, BelievesARightFlowAndNotAWrongOne) {
  const ProjectedImages images = two_images(3);
  render::FlowField right{160, 120, std::vector<float>(2 * 160 * 120, 0)}, wrong = right, back = right;
  for (std::size_t i = 0; i < right.uv.size(); i += 2) {
    right.uv[i] = 3;
    wrong.uv[i] = -3;
    back.uv[i] = -3;
  }
  const std::size_t middle = 60 * 160 + 80;
  EXPECT_TRUE(FlowTrust().run(images, 0, 1, right, &back)[middle]);
  EXPECT_FALSE(FlowTrust().run(images, 0, 1, wrong, nullptr)[middle]) << "it makes the pictures differ more";
  EXPECT_FALSE(FlowTrust().run(images, 0, 1, right, &right)[middle]) << "the way back does not lead home";
}

TEST(FlowTrust, GoesDownSteadilyAsTheWayBackMissesMore) {
  const ProjectedImages images = two_images(3);
  render::FlowField there{160, 120, std::vector<float>(2 * 160 * 120, 0)}, back = there;
  for (std::size_t i = 0; i < there.uv.size(); i += 2) there.uv[i] = 3;
  const std::size_t middle = 60 * 160 + 80;
  int before = 255;
  for (float miss = 0; miss < 1.6F; miss += 0.02F) {
    for (std::size_t i = 0; i < back.uv.size(); i += 2) back.uv[i] = miss - 3;
    const int now = FlowTrust().run(images, 0, 1, there, &back)[middle];
    ASSERT_LE(now, before) << miss;
    ASSERT_GE(now, before - 5) << "it goes at once at " << miss;
    before = now;
  }
  EXPECT_EQ(before, 0);
}

TEST(PictureFill, WhatIsKnownInPartLiesBetweenItselfAndItsSurroundings) {
  std::vector<float> values(16 * 16, 10);
  std::vector<std::uint8_t> known(16 * 16, 255);
  known[8 * 16 + 8] = 51;
  values[8 * 16 + 8] = 60;
  PictureFill().run(16, 16, 1, known.data(), values.data());
  EXPECT_NEAR(values[8 * 16 + 8], 10 + 0.2 * 50, 3) << "a fifth; it is among its own surroundings";
}

TEST(FlowTrust, BelievesNothingWhereAColorIsBorrowed) {
  render::ProjectedImages images = two_images(0);
  images.state[1].assign(images.state[1].size(), ProjectedImages::kFilled);
  const FlowField none{160, 120, std::vector<float>(2 * 160 * 120, 0)};
  EXPECT_THAT(FlowTrust().run(images, 0, 1, none, &none), testing::Each(0));
}

TEST(PairwiseFlows, HasBothDirections) {
  render::PairwiseFlows flows;
  ASSERT_THAT(flows.estimate(two_images(3), {true, true}, {}, 1), IsOk());
  ASSERT_EQ(flows.fields().size(), 2U);
  const std::size_t middle = 2 * (60 * 160 + 80);
  EXPECT_NEAR(flows.fields()[0].uv[middle], 3, 0.3);
  EXPECT_NEAR(flows.fields()[1].uv[middle], -3, 0.3);
}

TEST(PairwiseFlows, ContinuesTheFlowWhereAnImageHasNoColorOfItsOwn) {
  render::ProjectedImages images = two_images(3);
  for (int y = 40; y < 80; ++y)  // a hole filled from the other image: there it would look unmoved
    for (int x = 60; x < 90; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * 160 + static_cast<std::size_t>(x);
      images.state[1][i] = ProjectedImages::kFilled;
      images.gray[1][i] = images.gray[0][i];
    }
  render::PairwiseFlows flows;
  ASSERT_THAT(flows.estimate(images, {true, true}, {}, 1), IsOk());
  EXPECT_NEAR(flows.fields()[0].uv[2 * (60 * 160 + 75)], 3, 0.6);
}

TEST(PairwiseFlows, DropsDisplacementsWithinTheJitterOfTheFlow) {
  render::PairwiseFlows flows;
  ASSERT_THAT(flows.estimate(two_images(0.1), {true, true}, {}, 1), IsOk());
  EXPECT_EQ(flows.fields()[0].uv[2 * (60 * 160 + 80)], 0);
}

TEST(PairwiseFlows, LeavesOutImagesThatPullNothing) {
  render::PairwiseFlows flows;
  ASSERT_THAT(flows.estimate(two_images(3), {true, false}, {}, 1), IsOk());
  EXPECT_THAT(flows.fields()[0].uv, testing::Each(0.F));  // towards the second image
  EXPECT_NE(flows.fields()[1].uv[2 * (60 * 160 + 80)], 0);
}

}  // namespace
}  // namespace floatstage::render
