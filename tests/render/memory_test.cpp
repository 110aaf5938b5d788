// A program of its own: it replaces operator new to count.

#include "tests/render/stage.h"
#include "tests/support/counted_new.h"

namespace floatstage::render {
namespace {

class CpuRenderer : public testing::TestWithParam<std::tuple<const char*, int>> {};
INSTANTIATE_TEST_SUITE_P(MethodsAndThreads, CpuRenderer,
                         testing::Combine(testing::Values("nearest", "linear", "floating", "floating_depth"),
                                          testing::Values(1, 2)),
                         [](const auto& param) {
                           return std::string(std::get<0>(param.param)) + "_" +
                                  std::to_string(std::get<1>(param.param));
                         });

// Which thread works on what is up to the moment: a thread may come to its first piece of work late.
TEST_P(CpuRenderer, AllocatesNothingOnceItHasSeenItsViews) {
  const auto& [method, threads] = GetParam();
  const Stage stage = photographed(arc(5, 25), ball(0.25F, 48, 0.6F), ball(0.265F, 16, 0.6F));
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const bool depth = std::string_view(method) == "floating_depth";
  const auto renderer = std::move(*make_renderer(depth ? "floating" : method, render::BackEnd::Cpu));
  RendererOptions options;
  options.alignment = depth ? Alignment::Depth : Alignment::Flow;
  options.field_memory = depth ? 0.75 : 0;
  options.threads = threads;
  const View views[] = {view_at(8, 25, small_camera(256, 192)), view_at(-13, 5), view_at(3, 40)};
  constexpr int kWarmUp = 20, kCounted = 5;
  long counted = 0;
  for (int round = 0; round < kWarmUp + kCounted; ++round)
    for (const View& view : views) {
      const long before = test::allocations;
      const Result<RenderedView> picture = renderer->render(scene, view, options);
      const long during = test::allocations - before;
      ASSERT_THAT(picture, IsOk());
      if (round == 0) {
        EXPECT_GT(during + counted, 0) << "the counter counts";
        counted += during;
      }
      if (round >= kWarmUp) {
        EXPECT_EQ(during, 0) << "round " << round;
      }
    }
}

}  // namespace
}  // namespace floatstage::render
