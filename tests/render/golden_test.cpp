// Pictures compared with pictures looked at by a person. On failure expected, actual and difference are
// written to FLOATSTAGE_GOLDEN_OUT (a folder; default: golden_failures in the working folder).
// FLOATSTAGE_GOLDEN_UPDATE=1 writes the goldens anew, from the GL back-end: look at them before committing.

#include <cstdlib>
#include <filesystem>
#include <tuple>

#include "core/png.h"
#include "tests/render/walls.h"
#include "tests/support/places.h"

namespace floatstage::render {
namespace {

constexpr double kMeanTolerance = 1.0;      // 8-bit steps, over the covered pixels: drivers round differently
constexpr double kOutlierTolerance = 0.01;  // fraction of pixels that may be off by more than kOutlier
constexpr double kBelief = 3;               // the same, of what is asked of differences by single steps
constexpr int kOutlier = 24;

struct Golden {
  const char* name;
  const char* method;
  RenderOutput output;
  double coverage;  // fraction of the picture
  double mean[3];   // of the covered pixels
  double tolerance = kMeanTolerance;
};

const Golden kGoldens[] = {
    {"nearest", "nearest", RenderOutput::Color, 0.4742, {121.1, 129.1, 131.0}},
    {"linear", "linear", RenderOutput::Color, 0.4742, {121.1, 129.4, 131.9}},
    {"band_limited", "band-limited", RenderOutput::Color, 0.4742, {122.7, 130.7, 133.4}},
    {"filtered", "filtered", RenderOutput::Color, 0.4742, {121.4, 129.7, 132.0}},
    {"light_field", "light-field", RenderOutput::Color, 1, {124.1, 131.8, 134.0}},
    {"floating", "floating", RenderOutput::Color, 0.4742, {122.8, 130.9, 132.7}},
    {"floating_static", "floating-static", RenderOutput::Color, 0.4742, {121.0, 129.1, 131.5}},
    {"floating_static_flow", "floating-static", RenderOutput::Flow, 0.4837, {254.6, 227.4, 229.4}},
    {"floating_weights", "floating", RenderOutput::Weights, 0.4837, {138.9, 168.7, 110.1}},
    {"floating_soft_visibility", "floating", RenderOutput::SoftVisibility, 0.4837, {103.7, 91.3, 96.8}},
    {"linear_ghosting", "linear", RenderOutput::Ghosting, 0.4837, {153.8, 70.4, 26.5}},
    {"linear_visibility", "linear", RenderOutput::Visibility, 0.4837, {113.6, 100.0, 105.9}},
    {"linear_depth", "linear", RenderOutput::Depth, 0.4837, {184.5, 184.5, 184.5}},
    {"linear_opacity", "linear", RenderOutput::Opacity, 0.4742, {241.2, 241.2, 241.2}},
    {"linear_projected", "linear", RenderOutput::Projected, 0.4837, {96.4, 104.8, 103.9}},
    {"linear_aliasing", "linear", RenderOutput::Aliasing, 0.4837, {254.8, 183.3, 183.5}},
    {"linear_predicted", "linear", RenderOutput::Predicted, 0.4837, {206.5, 56.0, 62.3}},
    {"floating_flow", "floating", RenderOutput::Flow, 0.4837, {254.6, 208.7, 243.6}},
    {"floating_warped", "floating", RenderOutput::Warped, 0.4837, {114.7, 122.0, 124.3}},
    {"floating_position_weights", "floating", RenderOutput::PositionWeights, 0.4837, {167.4, 129.8, 122.5}},
    {"floating_color_weights", "floating", RenderOutput::ColorWeights, 0.4837, {136.1, 173.0, 101.7}},
    {"floating_field", "floating", RenderOutput::Field, 0.4837, {255, 148.1, 150.8}},
    {"floating_confidence", "floating", RenderOutput::Confidence, 0.4837, {102, 102, 102}, kBelief},
    {"floating_measured", "floating", RenderOutput::Measured, 0.4837, {199.5, 60.6, 65.6}},
};

std::filesystem::path golden_file(const Golden& golden) {
  return source_folder() / "tests/golden" / text("render_", golden.name, ".png");
}

void write_failure(const Golden& golden, const Image& expected, const Image& actual) {
  const char* wanted = std::getenv("FLOATSTAGE_GOLDEN_OUT");
  const std::filesystem::path folder = wanted != nullptr ? wanted : "golden_failures";
  std::filesystem::create_directories(folder);
  Image difference(actual.width, actual.height, 3);
  for (int y = 0; y < actual.height; ++y)
    for (int x = 0; x < actual.width; ++x)
      for (int c = 0; c < 3; ++c)
        difference.at(x, y)[c] =
            static_cast<std::uint8_t>(std::min(255, 4 * std::abs(actual.at(x, y)[c] - expected.at(x, y)[c])));
  for (const auto& [suffix, image] : {std::pair("expected", &expected), std::pair("actual", &actual),
                                      std::pair("diff", static_cast<const Image*>(&difference))})
    EXPECT_THAT(save_png(*image, folder / text(golden.name, "_", suffix, ".png")), IsOk());
}

using Case = std::tuple<Golden, render::BackEnd>;

class Goldens : public Rendering, public testing::WithParamInterface<Case> {
 protected:
  void SetUp() override { open(std::get<1>(GetParam())); }
};
INSTANTIATE_TEST_SUITE_P(Render, Goldens,
                         testing::Combine(testing::ValuesIn(kGoldens),
                                          testing::Values(render::BackEnd::Gl, render::BackEnd::Cpu)),
                         [](const auto& param) {
                           return text(std::get<0>(param.param).name, "_", name_of(std::get<1>(param.param)));
                         });

TEST_P(Goldens, LooksAsBefore) {
  const auto& [golden, back_end] = GetParam();
  // A flattened ball with a wrong proxy, so that ghosts, occlusion and soft visibility have something to
  // show.
  const bool grid = golden.method == std::string("light-field");
  const Stage stage =
      grid ? before_a_wall(3, 3) : photographed(arc(5, 25), ball(0.25F, 48, 0.6F), ball(0.265F, 16, 0.6F));
  render::RendererOptions options;
  options.uncertainty = 0.03;
  options.output = golden.output;
  const Image actual = rendered(stage, grid ? view_from(0.03, 0.02) : view_at(8, 25), golden.method, options);
  double covered = 0, mean[3] = {0, 0, 0};
  for (std::size_t i = 0; i < actual.pixels.size(); i += 4) {
    if (actual.pixels[i + 3] == 0) continue;
    ++covered;
    for (std::size_t c = 0; c < 3; ++c) mean[c] += actual.pixels[i + c];
  }
  for (double& m : mean) m /= covered;
  if (std::getenv("FLOATSTAGE_GOLDEN_UPDATE") != nullptr && back_end == render::BackEnd::Gl) {
    std::filesystem::create_directories(golden_file(golden).parent_path());
    ASSERT_THAT(save_png(actual, golden_file(golden)), IsOk());
    GTEST_SKIP() << golden.name << ": coverage " << covered / (actual.width * actual.height) << ", mean "
                 << mean[0] << ", " << mean[1] << ", " << mean[2];
  }
  EXPECT_NEAR(covered / (actual.width * actual.height), golden.coverage, 0.005);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], golden.mean[c], 2) << "channel " << c;

  const Result<Image> expected = load_png(golden_file(golden));
  ASSERT_THAT(expected, IsOk());
  ASSERT_EQ(expected->width, actual.width);
  ASSERT_EQ(expected->height, actual.height);
  ASSERT_EQ(expected->channels, 4);
  double sum = 0, outliers = 0;
  for (std::size_t i = 0; i < actual.pixels.size(); ++i) {
    const int difference = std::abs(actual.pixels[i] - expected->pixels[i]);
    sum += difference;
    outliers += difference > kOutlier;
  }
  EXPECT_LE(sum / (3 * covered), golden.tolerance);
  EXPECT_LE(outliers / static_cast<double>(actual.pixels.size()), kOutlierTolerance);
  if (HasFailure()) write_failure(golden, *expected, actual);
}

}  // namespace
}  // namespace floatstage::render
