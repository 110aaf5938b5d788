// render/cpu against its reference, render/gl, at small sizes.
#include <map>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

class BackEnds : public testing::Test {
 protected:
  void SetUp() override {
    Result<std::unique_ptr<GlContext>> made = GlContext::headless();
    ASSERT_THAT(made, IsOk());
    context_ = std::move(*made);
  }
  // Colours and which pixels the proxy covers; outline_test.cpp compares opacities.
  static Image drawn(render::BackEnd back_end, const render::Scene& scene, const View& view,
                     const char* method, RendererOptions options) {
    options.soft_outlines = false;
    const auto renderer = std::move(*make_renderer(method, back_end));
    const Result<RenderedView> picture = renderer->render(scene, view, options);
    EXPECT_THAT(picture, IsOk());
    return picture ? download(*picture) : Image{};
  }

 private:
  std::unique_ptr<GlContext> context_;
};

struct Difference {
  double psnr = 0;            // of pixels that both cover
  double coverage_share = 0;  // pixels that only one covers, of all
  double large_share = 0;     // of pixels that both cover: more than 24 steps apart in a channel
};

Difference difference(const Image& a, const Image& b) {
  Difference d;
  double both = 0, one = 0, large = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
    const bool in_a = a.pixels[i + 3] != 0, in_b = b.pixels[i + 3] != 0;
    one += in_a != in_b;
    if (!in_a || !in_b) continue;
    ++both;
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.pixels[i + c] - b.pixels[i + c]));
    large += most > 24;
  }
  d.psnr = psnr(a, b, [&](int x, int y) { return a.at(x, y)[3] != 0 && b.at(x, y)[3] != 0; });
  d.coverage_share = one / (static_cast<double>(a.pixels.size()) / 4);
  d.large_share = large / both;
  return d;
}

// A flattened ball with a wrong proxy: ghosts, occlusion and soft visibility have something to show.
Mesh troubled_ball() { return ball(0.25F, 48, 0.6F); }
Stage troubled(const CameraModel& model = small_camera()) {
  return photographed(arc(5, 25, model), troubled_ball(), ball(0.265F, 16, 0.6F));
}

TEST_F(BackEnds, DrawTheSamePictures) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.flow.backend = "none";  // a flow of pictures that differ by a step differs too
  options.uncertainty = 0.02;
  for (const char* method : {"nearest", "linear", "band-limited", "filtered", "floating", "floating-static"})
    for (const bool sharp : {true, false}) {
      options.sharp = sharp;
      const View view = view_at(8, 25, small_camera(256, 192));
      const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, method, options),
                                      drawn(render::BackEnd::Gl, scene, view, method, options));
      EXPECT_GT(d.psnr, method == std::string("nearest") ? 40 : 48) << method << ", sharp " << sharp;
      EXPECT_LE(d.coverage_share, 0.0002) << method << ", sharp " << sharp;
      RecordProperty(text(method, sharp ? "_sharp" : "_soft"), text(d.psnr, " dB"));
    }
}

TEST_F(BackEnds, DrawTheSameSmallPictures) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.flow.backend = "none";
  for (const char* method : {"nearest", "linear", "filtered", "floating", "floating-static"})
    for (const int width : {96, 48, 12}) {  // footprints of 1.7, 3.3 and 13 pixels
      const View view = view_at(8, 25, small_camera(width, 3 * width / 4));
      const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, method, options),
                                      drawn(render::BackEnd::Gl, scene, view, method, options));
      EXPECT_GT(d.psnr, 45) << method << ", " << width << " px wide";
    }
}

TEST_F(BackEnds, DrawTheSamePicturesWithTheSameFields) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.flow.backend = "variational";  // between photographs: both back-ends read the scene's
  for (const bool sharp : {true, false}) {
    options.sharp = sharp;
    for (const double degrees : {8, -17, 31}) {
      const View view = view_at(degrees, 25, small_camera(256, 192));
      const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, "floating-static", options),
                                      drawn(render::BackEnd::Gl, scene, view, "floating-static", options));
      EXPECT_GE(d.psnr, 50) << degrees << " degrees, sharp " << sharp;
      EXPECT_LE(d.coverage_share, 0.0002) << degrees << " degrees, sharp " << sharp;
    }
  }
}

TEST_F(BackEnds, DrawAsWellWithTheFlowOnTheGpu) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const View view = view_at(8, 25, small_camera(256, 192));
  const Photograph truth =
      photograph(troubled_ball(), view.model, view.view_from_world, 3, random_checker(0.04F, 5));
  RendererOptions options;
  options.flow.backend = "none";
  const Image still = drawn(render::BackEnd::Gl, scene, view, "floating", options);
  options.flow.backend = "variational";
  for (const int shrink : {1, 2}) {
    options.flow.shrink = shrink;
    options.flow.place = FlowPlace::Cpu;
    const Image expected = drawn(render::BackEnd::Gl, scene, view, "floating", options);
    options.flow.place = FlowPlace::Gpu;
    const Image found = drawn(render::BackEnd::Gl, scene, view, "floating", options);
    const Difference d = difference(found, expected);
    // Half floats decide here and there whether a displacement is believed.
    EXPECT_GT(d.psnr, 42) << "flow at 1/" << shrink;
    EXPECT_GT(d.psnr, difference(still, expected).psnr + 10) << "the flow moves nothing: nothing is tested";
    EXPECT_EQ(d.coverage_share, 0);
    auto inside = [&](int x, int y) { return well_inside(expected, x, y, 3); };
    const double on_gpu = psnr(found, truth.rgb, inside), on_cpu = psnr(expected, truth.rgb, inside);
    EXPECT_NEAR(on_gpu, on_cpu, 0.1) << "dB from the truth, flow at 1/" << shrink;
    RecordProperty(text("flow_at_1_", shrink), text(d.psnr, " dB apart; from the truth ", on_gpu,
                                                    " on the GPU, ", on_cpu, " on the CPU"));
  }
}

TEST_F(BackEnds, DrawWithTheFlowOnTheGpuAgainAndWithOtherCameras) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.flow.backend = "variational";
  options.flow.place = FlowPlace::Gpu;
  const auto renderer = std::move(*make_renderer("floating", render::BackEnd::Gl));
  std::map<int, Image> first;
  for (const int cameras : {3, 1, 2, 3, 2}) {
    options.cameras = cameras;
    const View view = view_at(cameras == 2 ? -20 : 8, 25, small_camera(cameras == 2 ? 160 : 256, 120));
    const Result<RenderedView> picture = renderer->render(scene, view, options);
    ASSERT_THAT(picture, IsOk());
    const Image image = download(*picture);
    const auto [entry, is_new] = first.try_emplace(cameras, image);
    EXPECT_EQ(image, entry->second) << cameras << " cameras, " << (is_new ? "first" : "again");
  }
}

TEST_F(BackEnds, DrawTheSamePicturesThroughLenses) {
  CameraModel model = small_camera();
  for (const Lens& lens :
       {Lens(BrownConrady{-0.25, 0.08, 0.002, -0.001, 0.01}), Lens(KannalaBrandt{0.05, -0.02, 0.01, 0})}) {
    model.lens = lens;
    const Stage stage = troubled(model);
    render::Scene scene;
    ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
    const View view = view_at(-13, 5);
    const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, "linear", {}),
                                    drawn(render::BackEnd::Gl, scene, view, "linear", {}));
    EXPECT_GT(d.psnr, 45);
    EXPECT_LE(d.coverage_share, 0.0002);
  }
}

TEST_F(BackEnds, ShowTheSameIntermediates) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const View view = view_at(8, 25, small_camera(256, 192));
  for (int output = 1; output < static_cast<int>(render_output_names().size()); ++output) {
    RendererOptions options;
    options.output = static_cast<RenderOutput>(output);
    // What ghosts depends on the flow, and that of pictures which differ by a step differs too.
    if (options.output == RenderOutput::Ghosting || options.output == RenderOutput::Warped)
      options.flow.backend = "none";
    const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, "floating", options),
                                    drawn(render::BackEnd::Gl, scene, view, "floating", options));
    EXPECT_LE(d.large_share, 0.02) << render_output_names()[static_cast<std::size_t>(output)];
    EXPECT_LE(d.coverage_share, 0.0002) << render_output_names()[static_cast<std::size_t>(output)];
  }
}

TEST_F(BackEnds, AgreeOnAMeshThatIsCutByTheNearPlaneOrHasHoles) {
  Stage stage = troubled();
  stage.scene.mesh.triangles.resize(stage.scene.mesh.triangles.size() * 2 / 3);  // open: its inside is seen
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  View view = view_at(8, 60);
  for (const double near_plane : {0.01, 0.9}) {
    view.near_plane = near_plane;
    const Difference d = difference(drawn(render::BackEnd::Cpu, scene, view, "linear", {}),
                                    drawn(render::BackEnd::Gl, scene, view, "linear", {}));
    EXPECT_LE(d.coverage_share, 0.0003) << "near plane at " << near_plane;
    EXPECT_LE(d.large_share, 0.01) << "near plane at " << near_plane;
  }
}

TEST_F(BackEnds, DrawOneSceneInTurns) {
  const Stage stage = troubled();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  std::map<render::BackEnd, Image> first;
  for (int turn = 0; turn < 2; ++turn)
    for (const render::BackEnd back_end : {render::BackEnd::Cpu, render::BackEnd::Gl}) {
      const Image picture = drawn(back_end, scene, view_at(3), "linear", {});
      if (turn == 0)
        first[back_end] = picture;
      else
        EXPECT_EQ(picture, first[back_end]);
    }
}

TEST(BackEnd, CpuNeedsNoOpenGl) {
  const auto opened = render::open_back_end(render::BackEnd::Cpu);
  ASSERT_THAT(opened, IsOk());
  EXPECT_EQ(opened->context, nullptr);
  EXPECT_EQ(opened->back_end, render::BackEnd::Cpu);
  EXPECT_THAT(opened->description, testing::HasSubstr("CPU"));
}

TEST(BackEnd, AutoTakesTheCpuWhereOpenGlIsSoftware) {
  const auto gl = GlContext::headless();
  const bool gpu = gl && !(*gl)->is_software();
  const auto opened = render::open_back_end(render::BackEnd::Auto);
  ASSERT_THAT(opened, IsOk());
  EXPECT_EQ(opened->back_end, gpu ? render::BackEnd::Gl : render::BackEnd::Cpu);
}

TEST(BackEnd, NamesAreListedAgainstUnknownOnes) {
  EXPECT_THAT(render::parse_back_end("cpu"), IsOk());
  EXPECT_THAT(render::parse_back_end("vulkan"), FailsWith(ErrorCode::InvalidArgument, "gl"));
}

}  // namespace
}  // namespace floatstage::render
