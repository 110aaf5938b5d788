// The pairs of Middlebury's optical flow set (Baker et al. 2011), with the bars that the solver is held to.

#include "core/png.h"
#include "render/flow.h"
#include "render/flow/flo_file.h"
#include "render/flow/flow_score.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::render::test {
namespace {

/// Mean end-point error over the four pairs, px.
double mean_error(const char* backend, const char* preset) {
  FlowOptions options;
  options.backend = backend;
  options.preset = preset;
  const auto estimator = make_flow_estimator(options);
  EXPECT_THAT(estimator, IsOk());
  double sum = 0;
  for (const char* name : {"RubberWhale", "Grove2", "Dimetrodon", "Venus"}) {
    const std::filesystem::path folder = real_data("flow") / name;
    const Result<Image> first = load_png(folder / "frame10.png"), second = load_png(folder / "frame11.png");
    const Result<FlowField> truth = load_flo(folder / "flow10.flo");
    EXPECT_THAT(first, IsOk());
    EXPECT_THAT(second, IsOk());
    EXPECT_THAT(truth, IsOk());
    const std::vector<std::uint8_t> a = flow_gray(*first), b = flow_gray(*second);
    const auto field = estimate_flow(**estimator, {first->width, first->height, a.data()},
                                     {second->width, second->height, b.data()});
    EXPECT_THAT(field, IsOk());
    const Result<FlowScore> score = score_flow(*field, *truth);
    EXPECT_THAT(score, IsOk());
    sum += score->epe / 4;
  }
  return sum;
}

TEST(MiddleburyFlow, IsRightToAFifthOfAPixelOnAverage) {
  FLOATSTAGE_NEEDS_DATA(real_data("flow"));
  const double quality = mean_error("variational", "quality");
  EXPECT_LE(quality, 0.17);
  EXPECT_LE(mean_error("variational", "fast"), 0.2) << "made for projections of photographs, not for these";
  EXPECT_LT(quality, mean_error("dis", "medium"))
      << "the older back-end, refined longer than OpenCV's preset";
}

}  // namespace
}  // namespace floatstage::render::test
