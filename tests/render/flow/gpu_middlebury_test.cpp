// What half floats cost the flow on the GPU: the middles of Middlebury's pairs, at a size that a software
// OpenGL can bear.

#include "core/png.h"
#include "render/flow/flo_file.h"
#include "render/flow/flow_score.h"
#include "render/gl_context.h"
#include "tests/render/flow/gpu_flow.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::render::test {
namespace {

constexpr int kWidth = 256, kHeight = 192;

struct Pair {
  std::vector<std::uint8_t> first, second;
  FlowField truth{kWidth, kHeight, {}};
};

/// The middle of a picture.
template <class T>
std::vector<T> middle(const std::vector<T>& pixels, int width, int height, int channels) {
  const int left = (width - kWidth) / 2, top = (height - kHeight) / 2;
  std::vector<T> part;
  for (int y = top; y < top + kHeight; ++y) {
    const auto row = pixels.begin() + static_cast<std::ptrdiff_t>(y * width + left) * channels;
    part.insert(part.end(), row, row + kWidth * channels);
  }
  return part;
}

Pair load(const char* name) {
  const std::filesystem::path folder = real_data("flow") / name;
  const Result<Image> a = load_png(folder / "frame10.png"), b = load_png(folder / "frame11.png");
  const Result<FlowField> truth = load_flo(folder / "flow10.flo");
  EXPECT_THAT(a, IsOk());
  EXPECT_THAT(b, IsOk());
  EXPECT_THAT(truth, IsOk());
  Pair pair;
  pair.first = middle(flow_gray(*a), a->width, a->height, 1);
  pair.second = middle(flow_gray(*b), b->width, b->height, 1);
  pair.truth.uv = middle(truth->uv, truth->width, truth->height, 2);
  return pair;
}

TEST(MiddleburyFlowOnTheGpu, HalfFloatsCostLessThanAHundredthOfAPixel) {
  FLOATSTAGE_NEEDS_DATA(real_data("flow"));
  const auto context = GlContext::headless();
  ASSERT_THAT(context, IsOk());
  for (const char* preset : {"fast", "quality"}) {
    FlowOptions options;
    options.backend = "variational";
    options.preset = preset;
    for (const char* name : {"RubberWhale", "Grove2", "Dimetrodon", "Venus"}) {
      const Pair pair = load(name);
      const FlowImage images[] = {{kWidth, kHeight, pair.first.data(), nullptr},
                                  {kWidth, kHeight, pair.second.data(), nullptr}};
      const FlowPair asked{0, 1};
      auto error = [&](const FlowField& field) { return score_flow(field, pair.truth)->epe; };
      const auto on_cpu = make_flow_estimator(options);
      const double cpu = error(*estimate_flow(**on_cpu, images[0], images[1]));
      const double full = error(GpuFlow(options, FlowPrecision::Float).estimate(images, {&asked, 1})[0]);
      const double half = error(GpuFlow(options, FlowPrecision::Half).estimate(images, {&asked, 1})[0]);
      EXPECT_NEAR(full, cpu, 1e-3) << preset << ", " << name;
      EXPECT_LE(half - full, 5e-3) << preset << ", " << name;
      RecordProperty(text(preset, "_", name), text("CPU ", cpu, ", float ", full, ", half ", half, " px"));
    }
  }
}

}  // namespace
}  // namespace floatstage::render::test
