#include <algorithm>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

class Renderers : public Rendering, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Renderers, testing::Values("nearest", "linear", "floating"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(Renderers, ACameraAtTheViewReturnsItsPhotograph) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  const View view = view_of(stage.rig.cameras[2]);
  const Image picture = rendered(stage, view, GetParam());
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
  EXPECT_EQ(rendered(stage, view, GetParam()), rendered(permuted, view, GetParam()));
  const View between = view_at(10);  // two cameras equally near
  EXPECT_EQ(rendered(stage, between, GetParam()), rendered(permuted, between, GetParam()));
}

TEST_P(Renderers, RenderingTwiceGivesTheSameBytes) {
  const Stage stage = photographed(arc(4, 20), ball(0.25F, 48), ball(0.27F, 24));
  EXPECT_EQ(rendered(stage, view_at(3), GetParam()), rendered(stage, view_at(3), GetParam()));
}

TEST_P(Renderers, AnEmptyMeshGivesTheBackground) {
  Stage stage = photographed(arc(3, 20), ball(0.25F, 24), ball(0.25F, 24));
  stage.scene.mesh = {};
  render::RendererOptions options;
  options.background = {0, 0, 1};
  const Image picture = rendered(stage, view_at(0), GetParam(), options);
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    ASSERT_EQ(picture.pixels[i], 0);
    ASSERT_EQ(picture.pixels[i + 2], 255);
    ASSERT_EQ(picture.pixels[i + 3], 0) << "alpha says the proxy is here";
  }
}

}  // namespace
}  // namespace floatstage::render
