#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/flow/variational_flow.h"
#include "tests/render/flow/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::render::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

std::unique_ptr<FlowEstimator> make(const char* preset, int finest_scale = 0) {
  FlowOptions options;
  options.backend = "variational";
  options.preset = preset;
  options.finest_scale = finest_scale;
  auto made = make_flow_estimator(options);
  EXPECT_THAT(made, IsOk());
  return std::move(*made);
}

FlowImage image(const std::vector<std::uint8_t>& gray) { return {kWidth, kHeight, gray.data(), nullptr}; }

class VariationalPreset : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Presets, VariationalPreset, testing::Values("quality", "fast"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(VariationalPreset, FindsAShiftToATwentiethOfAPixel) {
  const auto first = grainy(kWidth, kHeight, 0, 0);
  for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-3, 2), std::pair(7, -5)}) {
    const auto second = grainy(kWidth, kHeight, dx, dy);
    const auto flow = estimate_flow(*make(GetParam()), image(first), image(second));
    ASSERT_THAT(flow, IsOk());
    std::vector<double> errors;
    for (int y = 20; y < kHeight - 20; ++y)
      for (int x = 20; x < kWidth - 20; ++x) {
        const std::size_t i = 2 * static_cast<std::size_t>(y * kWidth + x);
        errors.push_back(std::hypot(flow->uv[i] - dx, flow->uv[i + 1] - dy));
      }
    std::sort(errors.begin(), errors.end());
    const double mean =
        std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
    EXPECT_LT(mean, 0.05) << dx << "," << dy;
    if (std::string(GetParam()) == "quality") {
      EXPECT_LT(errors[errors.size() * 99 / 100], 0.05) << dx << "," << dy;
      EXPECT_LT(errors.back(), 0.1) << dx << "," << dy;
    }
  }
}

TEST_P(VariationalPreset, EqualPicturesDoNotMoveAtAll) {
  const auto picture = wavy(kWidth, kHeight, 0, 0), state = disc(kWidth, kHeight);
  const FlowImage masked{kWidth, kHeight, picture.data(), state.data()};
  for (const FlowImage& one : {image(picture), masked}) {
    const auto flow = estimate_flow(*make(GetParam()), one, one);
    ASSERT_THAT(flow, IsOk());
    EXPECT_THAT(flow->uv, testing::Each(0.F));
  }
}

TEST_P(VariationalPreset, IsTheSameAtAnyThreadCountAndWhenUsedAgain) {
  const auto a = wavy(kWidth, kHeight, 0, 0), b = wavy(kWidth, kHeight, 2, 1),
             c = wavy(kWidth, kHeight, -1, 3);
  const auto round = disc(kWidth, kHeight);
  std::vector<std::uint8_t> half(round.size(), 0);
  std::fill(half.begin(), half.begin() + kWidth * kHeight / 2, std::uint8_t{255});
  const FlowImage images[] = {
      {kWidth, kHeight, a.data(), half.data()}, {kWidth, kHeight, b.data(), round.data()}, image(c)};
  const FlowPair pairs[] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  const auto estimator = make(GetParam());
  std::vector<FlowField> alone(6), together(6);
  ASSERT_THAT(estimator->estimate(images, pairs, {}, 1, alone), IsOk());
  ASSERT_THAT(estimator->estimate(images, pairs, {}, 3, together), IsOk());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(alone[i].uv, together[i].uv) << i;
  const auto single = estimate_flow(*make(GetParam()), images[2], images[1]);
  ASSERT_THAT(single, IsOk());
  EXPECT_EQ(single->uv, alone[5].uv);
}

TEST(VariationalFlow, TakesNoNoticeOfWhatIsNoEvidence) {
  const auto first = grainy(kWidth, kHeight, 0, 0);
  auto second = grainy(kWidth, kHeight, 3, 0);
  std::vector<std::uint8_t> own(first.size(), 255), state = own;
  for (int y = 40; y < 80; ++y)
    for (int x = 60; x < 90; ++x) {  // filled from the first: there it looks unmoved
      const auto i = static_cast<std::size_t>(y * kWidth + x);
      second[i] = first[i];
      state[i] = 128;
    }
  const auto flow = estimate_flow(*make("fast"), {kWidth, kHeight, first.data(), own.data()},
                                  {kWidth, kHeight, second.data(), state.data()});
  ASSERT_THAT(flow, IsOk());
  EXPECT_NEAR(flow->uv[2 * (60 * kWidth + 75)], 3, 0.25) << "in the middle of what is not known";
}

TEST(VariationalFlow, StopsAtTheOutlineOfTheProxy) {
  // The texture moves under an outline that does not, as the projections of two photographs do.
  const auto state = disc(kWidth, kHeight);
  auto first = grainy(kWidth, kHeight, 0, 0), second = grainy(kWidth, kHeight, 4, 0);
  for (std::size_t i = 0; i < state.size(); ++i)
    if (state[i] == 0) first[i] = second[i] = 0;
  for (const int finest : {0, 1}) {
    const auto flow = estimate_flow(*make("fast", finest), {kWidth, kHeight, first.data(), state.data()},
                                    {kWidth, kHeight, second.data(), state.data()});
    ASSERT_THAT(flow, IsOk());
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (state[i] == 0) {
        ASSERT_EQ(flow->uv[2 * i], 0);
      } else {
        ASSERT_NEAR(flow->uv[2 * i], 4, finest == 0 ? 0.6 : 1.0) << i % kWidth << "," << i / kWidth;
      }
    }
  }
}

TEST(VariationalFlow, StartsFromAnInitialFieldAndLeavesItAlone) {
  const auto first = grainy(kWidth, kHeight, 0, 0), second = grainy(kWidth, kHeight, 40, 0);
  const FlowImage images[] = {image(first), image(second)};
  const FlowPair pair{0, 1};
  FlowField near{kWidth, kHeight, std::vector<float>(2 * first.size(), 0)}, found;
  for (std::size_t i = 0; i < near.uv.size(); i += 2) near.uv[i] = 39;
  const FlowField before = near;
  const auto estimator = make("fast");
  ASSERT_THAT(estimator->estimate(images, {&pair, 1}, {&near, 1}, 1, {&found, 1}), IsOk());
  EXPECT_EQ(near.uv, before.uv);
  EXPECT_NEAR(found.uv[2 * (60 * kWidth + 60)], 40, 0.05);
  FlowField unknown;
  ASSERT_THAT(estimator->estimate(images, {&pair, 1}, {&unknown, 1}, 1, {&found, 1}), IsOk())
      << "a field without pixels is none";
  EXPECT_EQ(found.uv, estimate_flow(*make("fast"), images[0], images[1])->uv);
}

TEST(VariationalFlow, RefusesListsThatDoNotFitTogether) {
  const auto picture = wavy(kWidth, kHeight, 0, 0);
  const FlowImage images[] = {image(picture), image(picture)};
  const auto estimator = make("fast");
  FlowField fields[2];
  const FlowPair wrong{0, 2}, right{0, 1};
  EXPECT_THAT(estimator->estimate(images, {&wrong, 1}, {}, 1, {fields, 1}),
              FailsWith(ErrorCode::InvalidArgument, "picture 2 of 2"));
  EXPECT_THAT(estimator->estimate(images, {&right, 1}, {}, 1, {fields, 2}),
              FailsWith(ErrorCode::InvalidArgument, "1 pairs"));
  const FlowField small{2, 2, std::vector<float>(8)};
  EXPECT_THAT(estimator->estimate(images, {&right, 1}, {&small, 1}, 1, {fields, 1}),
              FailsWith(ErrorCode::InvalidArgument, "initial field of 2x2"));
}

TEST(VariationalFlow, RefusesUnknownPresetsAndScales) {
  FlowOptions options;
  options.backend = "variational";
  options.preset = "medium";
  EXPECT_THAT(make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "quality, fast"));
  options.preset = "fast";
  options.finest_scale = 4;
  EXPECT_THAT(make_flow_estimator(options), FailsWith(ErrorCode::InvalidArgument, "finest scale 4"));
}

}  // namespace
}  // namespace floatstage::render::test
