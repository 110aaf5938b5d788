// How much methods flicker on the studio's dancer, between its cameras. FLOATSTAGE_LONG=1 holds the bar, at
// full size; the short form only that floating flickers less.
#include <cmath>
#include <map>

#include "pipeline/evaluate/evaluate.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

// Sixteen cameras, of which every second one is drawn from; four of the others are compared with.
TEST(FlickerOfTheDancer, IsLessFloatingThanBlended) {
  const bool is_long = wants_long_tests();
  TempFolder folder;
  SynthesizeOptions studio;
  studio.out = folder / "take";
  studio.rig.cameras = 16;
  studio.rig.width = is_long ? 640 : 320;
  studio.rig.height = is_long ? 480 : 240;
  studio.studio.samples = is_long ? 9 : 4;
  studio.frames = is_long ? 5 : 3;
  ASSERT_THAT(synthesize_take(studio), IsOk());
  ASSERT_THAT(process_take({.take = studio.out, .matte = "chroma"}), IsOk());
  const auto take = capture::TakeReader::open(studio.out);
  ASSERT_THAT(take, IsOk());
  EvaluateOptions options{.inputs = {"every:2"},
                          .hold_out = {"cam01", "cam05", "cam09", "cam13"},
                          .methods = {"linear", "floating"},
                          .frames = {},
                          .renderer = {},
                          .proxy = {}};
  options.renderer.back_end = render::BackEnd::Cpu;
  for (int frame = 0; frame < studio.frames; ++frame) options.frames.push_back(frame);
  std::map<std::string, double> sum;
  int scored = 0;
  ASSERT_THAT(evaluate_take(**take, options,
                            [&](const HeldOutView& view) -> Result<void> {
                              if (view.frame == 0) return {};
                              ++scored;
                              for (const auto& [method, scores] : view.scores) sum[method] += scores.flicker;
                              return {};
                            }),
              IsOk());
  EXPECT_EQ(scored, 4 * (studio.frames - 1));
  const double ratio = sum.at("floating") / sum.at("linear");
  RecordProperty("ratio", std::to_string(ratio));
  EXPECT_LE(ratio, is_long ? 0.90 : 0.98);
}

}  // namespace
}  // namespace floatstage::pipeline
