// What renderers show instead of the view: that each output says what it promises.
#include "render/inspection.h"

#include "render/cpu/false_color.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr float kRadius = 0.25F;

Image shown(const Stage& stage, const View& view, const std::string& method, const RendererOptions& options) {
  Scene scene;
  EXPECT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  auto renderer = make_renderer(method, BackEnd::Cpu);
  EXPECT_THAT(renderer, IsOk());
  const Result<RenderedView> rendered = (*renderer)->render(scene, view, options);
  EXPECT_THAT(rendered, IsOk());
  return rendered ? download(*rendered) : Image();
}

// The share of the covered pixels that are of a class.
double share(const Image& picture, BlendClass of_blend) {
  const std::array<float, 3> color = cpu::class_color(of_blend);
  double covered = 0, found = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    if (picture.pixels[i + 3] == 0) continue;
    ++covered;
    found += picture.pixels[i] == static_cast<int>(color[0]) &&
             picture.pixels[i + 2] == static_cast<int>(color[2]);
  }
  return found / covered;
}

std::array<double, 3> mean_color(const Image& picture) {
  std::array<double, 3> sum{};
  double covered = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
    if (picture.pixels[i + 3] == 0) continue;
    ++covered;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += picture.pixels[i + c];
  }
  for (double& c : sum) c /= covered;
  return sum;
}

TEST(BlendClasses, AreThoseOfTheThesis) {
  EXPECT_EQ(blend_class(0.5F, 1, 1), BlendClass::Sharp) << "Eq. 9.10";
  EXPECT_EQ(blend_class(1.5F, 2, 2), BlendClass::Blurred) << "Eq. 9.11: apart, but within both supports";
  EXPECT_EQ(blend_class(1.5F, 1, 2), BlendClass::Ghost) << "Eq. 9.12: the narrower support decides";
  EXPECT_EQ(blend_class(2.5F, 2, 2), BlendClass::Ghost);
  EXPECT_EQ(blend_class(0, 2, 1), BlendClass::Blurred) << "Eq. 9.9: enlarged photographs are soft";
  EXPECT_EQ(blend_class(0, 0.3F, 0.3F), BlendClass::Sharp)
      << "smaller ones are filtered to the view's pixels";
}

TEST(Predicted, TurnsIntoGhostsWhereAnErrorOfDepthParallaxesByAPixel) {
  // Two cameras 20° apart about a ball, seen from between: on the ball's near side an error e along the ray
  // moves each by about f e tan(10°) / z from the other's side, z = 1 - radius.
  const Stage stage = photographed(arc(2, 20), ball(kRadius), ball(kRadius));
  const View view = view_at(0);
  const double diagonal = 2 * kRadius * std::sqrt(3.0), z = 1 - kRadius;
  const double of_a_pixel = z / (view.model.fx * 2 * std::tan(10 * M_PI / 180));
  RendererOptions options;
  options.cameras = 2;
  options.output = RenderOutput::Predicted;
  options.uncertainty = 0.4 * of_a_pixel / diagonal;
  const Image below = shown(stage, view, "linear", options);
  options.uncertainty = 2 * of_a_pixel / diagonal;
  const Image above = shown(stage, view, "linear", options);
  const int x = view.model.width / 2, y = view.model.height / 2;
  const auto at = [&](const Image& picture) { return std::array{picture.at(x, y)[0], picture.at(x, y)[1]}; };
  EXPECT_EQ(at(below), (std::array<std::uint8_t, 2>{64, 176})) << "sharp";
  EXPECT_EQ(at(above), (std::array<std::uint8_t, 2>{224, 48})) << "ghosts";
  options.uncertainty = 0;
  EXPECT_EQ(share(shown(stage, view, "linear", options), BlendClass::Ghost), 0) << "the proxy is right";
}

TEST(Predicted, OnePhotographHasNoGhosts) {
  const Stage stage = photographed(arc(3, 20), ball(kRadius), ball(kRadius));
  RendererOptions options;
  options.output = RenderOutput::Predicted;
  options.uncertainty = 0.1;
  EXPECT_EQ(share(shown(stage, view_at(7), "nearest", options), BlendClass::Ghost), 0);
  EXPECT_GT(share(shown(stage, view_at(7), "linear", options), BlendClass::Ghost), 0.8);
}

TEST(Measured, FindsGhostsWhereTheProxyIsWrongAndNoneWhereItIsRight) {
  RendererOptions options;
  options.output = RenderOutput::Measured;
  const Stage right = photographed(arc(5, 20), ball(kRadius, 64), ball(kRadius, 64));
  const Stage wrong = photographed(arc(5, 20), ball(kRadius, 64), ball(1.12F * kRadius, 64));
  const double of_right = share(shown(right, view_at(7), "floating", options), BlendClass::Ghost);
  const double of_wrong = share(shown(wrong, view_at(7), "floating", options), BlendClass::Ghost);
  EXPECT_LT(of_right, 0.05);
  EXPECT_GT(of_wrong, 0.4);
}

TEST(Aliasing, IsWhiteAtOneToOneAndBlueWhereTheViewIsSmaller) {
  const Stage stage = photographed(arc(3, 20), ball(kRadius), ball(kRadius));
  RendererOptions options;
  options.output = RenderOutput::Aliasing;
  options.cameras = 1;
  const Image same = shown(stage, view_of(stage.rig.cameras[1]), "linear", options);
  for (const double c : mean_color(same)) EXPECT_GT(c, 245);
  const Image small = shown(stage, view_at(0, 10, small_camera(80, 60)), "linear", options);
  EXPECT_NEAR(mean_color(small)[0], 127.5, 12) << "half as large: an octave of two";
  EXPECT_GT(mean_color(small)[2], 245);
  const Image large = shown(stage, view_at(0, 10, small_camera(320, 240)), "linear", options);
  EXPECT_NEAR(mean_color(large)[2], 127.5, 12) << "twice as large";
  EXPECT_GT(mean_color(large)[0], 245);
}

TEST(Projected, IsTheShownCamerasPhotographWhereItSees) {
  const Stage stage = photographed(arc(3, 20), ball(kRadius), ball(kRadius));
  const View view = view_of(stage.rig.cameras[1]);
  RendererOptions options;
  options.output = RenderOutput::Projected;
  options.shown_camera = 1;
  const Image picture = shown(stage, view, "linear", options);
  const Image photograph = *to_rgb(stage.scene.images.frames[1]);
  EXPECT_GT(psnr(picture, photograph, [&](int x, int y) { return picture.at(x, y)[3] > 0; }), 35)
      << "from its own place it is the photograph";
  options.shown_camera = 2;
  const Image other = shown(stage, view, "linear", options);
  int dark = 0, covered = 0;
  for (std::size_t i = 0; i < other.pixels.size(); i += 4) {
    covered += other.pixels[i + 3] > 0;
    dark += other.pixels[i + 3] > 0 && other.pixels[i] + other.pixels[i + 1] + other.pixels[i + 2] == 0;
  }
  EXPECT_GT(dark, covered / 50) << "the far side, which it does not see";
  EXPECT_LT(dark, covered / 3);
}

TEST(ShownCameras, ThatTheViewIsNotDrawnFromLeaveItBlack) {
  const Stage stage = photographed(arc(7, 15), ball(kRadius), ball(kRadius));
  RendererOptions options;
  options.cameras = 2;
  options.shown_camera = 6;
  for (const RenderOutput output :
       {RenderOutput::Projected, RenderOutput::Warped, RenderOutput::Field, RenderOutput::Confidence}) {
    options.output = output;
    const Image picture = shown(stage, view_of(stage.rig.cameras[0]), "floating", options);
    for (const double c : mean_color(picture)) EXPECT_EQ(c, 0) << render_output_names()[std::size_t(output)];
  }
}

TEST(ShownCameras, ThatAreLackingAreSaid) {
  RenderedView view;
  for (const int camera : {3, 5}) view.cameras.push_back(camera);
  RendererOptions options;
  options.shown_camera = 5;
  options.towards_camera = 4;
  options.output = RenderOutput::Projected;
  EXPECT_FALSE(lacks_shown_camera(view, options));
  options.output = RenderOutput::Field;
  EXPECT_TRUE(lacks_shown_camera(view, options)) << "the other one";
  options.shown_camera = 4;
  EXPECT_TRUE(lacks_shown_camera(view, options));
  options.output = RenderOutput::Color;
  EXPECT_FALSE(lacks_shown_camera(view, options)) << "it is about none";
}

TEST(Field, LeadsFromOneImageToTheOtherAndBack) {
  // The proxy is too large: the projected images are apart, each way the other's opposite.
  const Stage stage = photographed(arc(2, 20), ball(kRadius, 64), ball(1.08F * kRadius, 64));
  RendererOptions options;
  options.cameras = 2;
  options.output = RenderOutput::Field;
  options.shown_camera = 0;
  options.towards_camera = 1;
  const std::array<double, 3> there = mean_color(shown(stage, view_at(0), "floating", options));
  std::swap(options.shown_camera, options.towards_camera);
  const std::array<double, 3> back = mean_color(shown(stage, view_at(0), "floating", options));
  EXPECT_GT(std::abs(there[0] - back[0]), 20) << "opposite directions have opposite hues";
  options.output = RenderOutput::Confidence;
  EXPECT_GT(mean_color(shown(stage, view_at(0), "floating", options))[0], 100) << "most of it is believed";
  options.flow.backend = "none";
  EXPECT_EQ(mean_color(shown(stage, view_at(0), "floating", options))[0], 0) << "nothing was estimated";
}

TEST(WeightsOfPositions, AreTheAngularOnesAsPublished) {
  const Stage stage = photographed(arc(5, 20), ball(kRadius), ball(kRadius));
  RendererOptions options;
  options.positions = Positions::Mean;
  options.output = RenderOutput::PositionWeights;
  const Image mean = shown(stage, view_at(7), "floating", options);
  options.positions = Positions::Parallax;
  const Image parallax = shown(stage, view_at(7), "floating", options);
  EXPECT_NE(mean.pixels, parallax.pixels);
  for (const Image* picture : {&mean, &parallax})
    for (std::size_t i = 0; i < picture->pixels.size(); i += 4) {
      const std::uint8_t* p = picture->pixels.data() + i;
      ASSERT_TRUE(p[3] == 0 || p[0] + p[1] + p[2] >= 180) << "sum one, and all colours are a quarter white";
    }
}

TEST(Outputs, ThatARendererHasNotAreRefusedWithThoseItHas) {
  const Stage stage = photographed(arc(3, 20), ball(kRadius), ball(kRadius));
  Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  for (const std::string method : {"nearest", "linear", "filtered", "floating-static"})
    for (const RenderOutput output :
         {RenderOutput::Warped, RenderOutput::Confidence, RenderOutput::Measured}) {
      auto renderer = make_renderer(method, BackEnd::Cpu);
      ASSERT_THAT(renderer, IsOk());
      RendererOptions options;
      options.output = output;
      const Result<RenderedView> rendered = (*renderer)->render(scene, view_at(3), options);
      ASSERT_FALSE(rendered);
      EXPECT_EQ(rendered.error().code, ErrorCode::InvalidArgument);
      EXPECT_THAT(rendered.error().message, testing::HasSubstr("predicted")) << "what it has";
      EXPECT_THAT(rendered.error().message, testing::HasSubstr(method));
      EXPECT_FALSE(can_show(method, output));
    }
}

}  // namespace
}  // namespace floatstage::render
