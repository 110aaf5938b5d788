// The flow in compute kernels against render/flow, at sizes that a software OpenGL can bear.
#include "tests/render/flow/gpu_flow.h"

#include <cmath>

#include "render/flow/variational_flow.h"
#include "render/gl/floating_flow.h"
#include "render/stage_times.h"
#include "render/gl_context.h"
#include "render/pairwise_flows.h"
#include "tests/render/flow/pictures.h"
#include "tests/support/matchers.h"

namespace floatstage::render::test {
namespace {

constexpr int kWidth = 160, kHeight = 120;

FlowOptions options_of(const char* preset, int finest_scale = 0) {
  FlowOptions options;
  options.backend = "variational";
  options.preset = preset;
  options.finest_scale = finest_scale;
  return options;
}

FlowImage image(const std::vector<std::uint8_t>& gray, const std::vector<std::uint8_t>* state = nullptr) {
  return {kWidth, kHeight, gray.data(), state == nullptr ? nullptr : state->data()};
}

/// How far two fields are apart, px.
struct Apart {
  double mean = 0, p99 = 0, most = 0;
};
Apart apart(const FlowField& a, const FlowField& b) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < a.uv.size(); i += 2)
    distances.push_back(std::hypot(a.uv[i] - b.uv[i], a.uv[i + 1] - b.uv[i + 1]));
  std::sort(distances.begin(), distances.end());
  Apart result;
  for (double d : distances) result.mean += d / static_cast<double>(distances.size());
  result.p99 = distances[distances.size() * 99 / 100];
  result.most = distances.back();
  return result;
}

class GpuFlowTest : public testing::Test {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<GlContext>> made = GlContext::headless();
    ASSERT_THAT(made, IsOk());
    context_ = std::move(*made);
  }
  static std::vector<FlowField> on_cpu(const FlowOptions& options, std::span<const FlowImage> images,
                                       std::span<const FlowPair> pairs) {
    std::vector<FlowField> fields(pairs.size());
    EXPECT_THAT((*make_variational_flow(options))->estimate(images, pairs, {}, 1, fields), IsOk());
    return fields;
  }

 private:
  std::unique_ptr<GlContext> context_;
};

constexpr FlowPair kThereAndBack[] = {{0, 1}, {1, 0}};

TEST_F(GpuFlowTest, PreparesPicturesAsTheCpuDoes) {
  for (const bool masked : {false, true}) {
    constexpr int width = 97, height = 61;
    const auto gray = wavy(width, height, 0, 0), state = disc(width, height);
    const FlowImage picture{width, height, gray.data(), masked ? state.data() : nullptr};
    const FlowImage images[] = {picture, picture};
    GpuFlow gpu(options_of("fast"), FlowPrecision::Float);
    gpu.estimate(images, kThereAndBack);
    PicturePyramid pyramid;
    const FlowLevels& levels = gpu.solver().levels();
    pyramid.build(picture, levels.count(), gpu.preset().pyramid);
    for (int l = 0; l < levels.count(); ++l) {
      const PictureLevel& expected = pyramid.level(l);
      const int w = expected.width, h = expected.height;
      ASSERT_EQ(levels[l].width, w);
      ASSERT_EQ(levels[l].height, h);
      const auto samples =
          layer_of<std::uint16_t>(levels[l].samples, 1, w, h, 1, GL_RED_INTEGER, GL_UNSIGNED_SHORT);
      const auto weights = layer_of<float>(levels[l].weights, 1, w, h, 2, GL_RG, GL_FLOAT);
      std::vector<std::uint16_t> spans(static_cast<std::size_t>(2 * h));
      glGetTextureSubImage(levels[l].spans.id(), 0, 0, 1, 0, h, 1, 1, GL_RG_INTEGER, GL_UNSIGNED_SHORT,
                           static_cast<GLsizei>(spans.size() * 2), spans.data());
      const SampledPicture sampled = expected.sampled();
      for (int y = 0; y < h; ++y) {
        const SplitSpan span = expected.spans[static_cast<std::size_t>(y)];
        ASSERT_EQ(spans[static_cast<std::size_t>(2 * y)], 2 * span.begin) << l << ", row " << y;
        ASSERT_EQ(spans[static_cast<std::size_t>(2 * y) + 1], 2 * span.end) << l << ", row " << y;
        for (int x = 0; x < w; ++x) {
          const std::size_t i = expected.at(x, y);
          const std::uint16_t sample = sampled.origin[y * sampled.stride + x];
          ASSERT_EQ(samples[i] & 1, sample & 1) << l << ": " << x << "," << y;
          ASSERT_NEAR(samples[i] >> 1, sample >> 1, 1) << l << ": " << x << "," << y;
          const float stiffness = expected.stiffness.at(x, y);
          ASSERT_NEAR(weights[2 * i], stiffness, 1e-4F * stiffness) << l << ": " << x << "," << y;
          ASSERT_NEAR(weights[2 * i + 1], expected.data.at(x, y), 1e-6) << l << ": " << x << "," << y;
        }
      }
    }
  }
}

TEST_F(GpuFlowTest, GivesTheFieldsOfTheCpu) {
  const auto a = grainy(kWidth, kHeight, 0, 0), b = grainy(kWidth, kHeight, 3, -2),
             state = disc(kWidth, kHeight);
  for (const char* preset : {"fast", "quality"})
    for (const int finest : {0, 1})
      for (const bool masked : {false, true}) {
        const FlowImage images[] = {image(a, masked ? &state : nullptr), image(b, masked ? &state : nullptr)};
        const FlowOptions options = options_of(preset, finest);
        const auto expected = on_cpu(options, images, kThereAndBack);
        const auto found = GpuFlow(options, FlowPrecision::Float).estimate(images, kThereAndBack);
        const auto halved = GpuFlow(options, FlowPrecision::Half).estimate(images, kThereAndBack);
        for (std::size_t k = 0; k < 2; ++k) {
          const std::string which = text(preset, finest, masked ? "_masked" : "", k);
          const Apart full = apart(found[k], expected[k]), half = apart(halved[k], expected[k]);
          // Where a displacement ends beside what is no evidence, the last bit decides what is read.
          EXPECT_LT(full.mean, 2e-4) << which;
          EXPECT_LT(full.p99, masked ? 2e-3 : 1e-4) << which;
          EXPECT_LT(full.most, 0.1) << which;
          EXPECT_LT(half.mean, 6e-3) << which;
          EXPECT_LT(half.p99, 0.1) << which;
        }
      }
}

TEST_F(GpuFlowTest, FusedSweepsGiveTheBitsOfSingleOnes) {
  const auto a = grainy(kWidth, kHeight, 0, 0), b = grainy(kWidth, kHeight, 2, 1),
             state = disc(kWidth, kHeight);
  const FlowImage images[] = {image(a, &state), image(b, &state)};
  const auto single = GpuFlow(options_of("fast"), FlowPrecision::Float, 1).estimate(images, kThereAndBack);
  for (const int fused : {2, 5, 10}) {
    const auto together =
        GpuFlow(options_of("fast"), FlowPrecision::Float, fused).estimate(images, kThereAndBack);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(together[k].uv, single[k].uv) << fused << " sweeps at once";
  }
}

TEST_F(GpuFlowTest, EqualPicturesDoNotMoveAtAll) {
  const auto picture = wavy(kWidth, kHeight, 0, 0), state = disc(kWidth, kHeight);
  for (const char* preset : {"fast", "quality"})
    for (const FlowPrecision precision : {FlowPrecision::Half, FlowPrecision::Float}) {
      const FlowImage images[] = {image(picture), image(picture), image(picture, &state),
                                  image(picture, &state)};
      const FlowPair pairs[] = {{0, 1}, {2, 3}};
      for (const FlowField& field : GpuFlow(options_of(preset), precision).estimate(images, pairs))
        EXPECT_THAT(field.uv, testing::Each(0.F)) << preset;
    }
}

TEST_F(GpuFlowTest, FindsAShiftToATwentiethOfAPixel) {
  const auto first = grainy(kWidth, kHeight, 0, 0);
  for (const char* preset : {"fast", "quality"})
    for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-3, 2), std::pair(7, -5)}) {
      const auto second = grainy(kWidth, kHeight, dx, dy);
      const FlowImage images[] = {image(first), image(second)};
      const FlowPair pair{0, 1};
      const auto found = GpuFlow(options_of(preset), FlowPrecision::Half).estimate(images, {&pair, 1});
      double sum = 0, count = 0;
      for (int y = 20; y < kHeight - 20; ++y)
        for (int x = 20; x < kWidth - 20; ++x, ++count) {
          const std::size_t i = 2 * static_cast<std::size_t>(y * kWidth + x);
          sum += std::hypot(found[0].uv[i] - dx, found[0].uv[i + 1] - dy);
        }
      EXPECT_LT(sum / count, 0.05) << preset << " " << dx << "," << dy;
    }
}

TEST_F(GpuFlowTest, SixFieldsTogetherAreEachAsAlone) {
  const auto a = wavy(kWidth, kHeight, 0, 0), b = wavy(kWidth, kHeight, 2, 1),
             c = wavy(kWidth, kHeight, -1, 3);
  const auto round = disc(kWidth, kHeight);
  std::vector<std::uint8_t> upper(round.size(), 0);
  std::fill(upper.begin(), upper.begin() + kWidth * kHeight / 2, std::uint8_t{255});
  const FlowImage images[] = {image(a, &upper), image(b, &round), image(c)};
  const FlowPair pairs[] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  GpuFlow gpu(options_of("fast"), FlowPrecision::Half);
  const auto together = gpu.estimate(images, pairs);
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_EQ(gpu.estimate(images, {&pairs[k], 1})[0].uv, together[k].uv) << k;
  const auto again = GpuFlow(options_of("fast"), FlowPrecision::Half).estimate(images, pairs);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(again[k].uv, together[k].uv) << "used again, " << k;
}

TEST_F(GpuFlowTest, ListsOnlyTilesThatTheProxyTouches) {
  const auto gray = wavy(kWidth, kHeight, 0, 0);
  std::vector<std::uint8_t> state(gray.size(), 0);
  for (int y = 40; y < 50; ++y)
    for (int x = 40; x < 50; ++x) state[static_cast<std::size_t>(y * kWidth + x)] = 255;
  const FlowImage images[] = {image(gray, &state), image(gray, &state)};
  GpuFlow gpu(options_of("fast"), FlowPrecision::Half);
  gpu.estimate(images, kThereAndBack);
  GLuint header[4];  // groups, count
  glGetNamedBufferSubData(gpu.solver().levels()[0].tiles.id(), 0, sizeof header, header);
  EXPECT_EQ(header[3], 2U) << "one tile a picture, of twenty";
  EXPECT_EQ(header[2], 1U) << "one field looks from each";
}

TEST_F(GpuFlowTest, ContinuesWhatIsNotBelievedAsTheCpuDoes) {
  // Pictures that agree in part: the lower half of the second moves differently and has holes.
  auto a = grainy(kWidth, kHeight, 0, 0), b = grainy(kWidth, kHeight, 3, -2);
  const auto other = grainy(kWidth, kHeight, 200, 90), state = disc(kWidth, kHeight);
  std::copy(other.begin() + kWidth * 70, other.begin() + kWidth * 95, b.begin() + kWidth * 70);
  for (std::size_t i = 0; i < state.size(); ++i)
    if (state[i] == 0) a[i] = b[i] = 0;
  const FlowImage images[] = {image(a, &state), image(b, &state)};
  const FlowOptions options = options_of("fast");
  ProjectedImages pictures{kWidth, kHeight, {a, b}, {state, state}};
  PairwiseFlows expected;
  ASSERT_THAT(expected.estimate(pictures, {true, true}, options, 1), IsOk());

  GpuFlow gpu(options, FlowPrecision::Float);
  gpu.estimate(images, kThereAndBack);
  auto finish = std::move(*FloatingFlow::create(FlowPrecision::Float));
  gl::Texture flows;
  finish.make_dependable(gpu.solver(), gpu.tables(), upload_pictures(images), kWidth, kHeight, flows);
  for (int k = 0; k < 2; ++k) {
    const FlowField found{kWidth, kHeight, layer_of<float>(flows, k, kWidth, kHeight, 2, GL_RG, GL_FLOAT)};
    const Apart d = apart(found, expected.fields()[static_cast<std::size_t>(k)]);
    EXPECT_LT(d.mean, 5e-3)
        << k;  // a pixel that is just believed here and just not there moves what is around
    EXPECT_LT(d.p99, 0.1) << k;
  }
}

TEST_F(GpuFlowTest, IsTimedStageByStage) {
  const auto a = wavy(64, 48, 0, 0);
  const FlowImage picture{64, 48, a.data(), nullptr}, images[] = {picture, picture};
  GpuFlow gpu(options_of("fast"), FlowPrecision::Half);
  StageTimes times;
  gpu.estimate(images, kThereAndBack);
  const auto stages = times.take();
  std::vector<std::string> names;
  for (const StageTime& stage : stages) {
    names.push_back(stage.name);
    EXPECT_GT(stage.milliseconds, 0) << stage.name;
    EXPECT_GT(stage.dispatches, 0) << stage.name;
    EXPECT_GT(stage.least_megabytes, 0) << stage.name;
  }
  EXPECT_THAT(names, testing::ElementsAre("pyramids", "equations", "sweeps", "enlargements"));
  EXPECT_TRUE(times.take().empty()) << "nothing since";
}

}  // namespace
}  // namespace floatstage::render::test
