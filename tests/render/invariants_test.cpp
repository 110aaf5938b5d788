#include <algorithm>
#include <tuple>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

using Kind = std::tuple<render::BackEnd, const char*>;

class Renderers : public Rendering, public testing::WithParamInterface<Kind> {
 protected:
  void SetUp() override { open(std::get<0>(GetParam())); }
  static const char* method() { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(All, Renderers,
                         testing::Combine(testing::Values(render::BackEnd::Cpu, render::BackEnd::Gl),
                                          testing::Values("nearest", "linear", "band-limited", "filtered",
                                                          "floating", "floating-static")),
                         [](const auto& param) {
                           std::string name =
                               text(std::get<1>(param.param), "_", name_of(std::get<0>(param.param)));
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(Renderers, ACameraAtTheViewReturnsItsPhotograph) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  const View view = view_of(stage.rig.cameras[2]);
  const Image picture = rendered(stage, view, method());
  const Image truth = *to_rgb(stage.scene.images.frames[2]);
  EXPECT_GE(psnr(picture, truth,
                 [&](int x, int y) {
                   return well_inside(picture, x, y, 2) && stage.scene.mattes[2].row(y)[x] == 255;
                 }),
            45);
}

TEST_P(Renderers, TheOrderOfTheCamerasDoesNotMatter) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  Stage permuted = stage;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::size_t from = (3 * i + 1) % 5;
    permuted.rig.cameras[i] = stage.rig.cameras[from];
    permuted.scene.images.frames[i] = stage.scene.images.frames[from];
    permuted.scene.mattes[i] = stage.scene.mattes[from];
  }
  const View view = view_at(7);
  EXPECT_EQ(rendered(stage, view, method()), rendered(permuted, view, method()));
  const View between = view_at(10);  // two cameras equally near
  EXPECT_EQ(rendered(stage, between, method()), rendered(permuted, between, method()));
}

TEST_P(Renderers, RenderingTwiceGivesTheSameBytes) {
  const Stage stage = photographed(arc(4, 20), ball(0.25F, 48), ball(0.27F, 24));
  EXPECT_EQ(rendered(stage, view_at(3), method()), rendered(stage, view_at(3), method()));
}

TEST_P(Renderers, AnEmptyMeshGivesTheBackground) {
  Stage stage = photographed(arc(3, 20), ball(0.25F, 24), ball(0.25F, 24));
  stage.scene.mesh = {};
  render::RendererOptions options;
  options.background = {0, 0, 1};
  const Image picture = rendered(stage, view_at(0), method(), options);
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    ASSERT_EQ(picture.pixels[i], 0);
    ASSERT_EQ(picture.pixels[i + 2], 255);
    ASSERT_EQ(picture.pixels[i + 3], 0) << "alpha says the proxy is here";
  }
}

}  // namespace
}  // namespace floatstage::render
