// One depth a pixel for all photographs at once (RendererOptions::alignment).
#include "render/depth_flow.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "render/parallaxes.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr int kWidth = 160, kHeight = 120;

// A plain wave, brightness at (x, y).
float wave(float x, float y) {
  return 128 + 50 * std::sin(0.31F * x) * std::cos(0.23F * y) + 30 * std::sin(0.11F * x + 0.17F * y);
}

// Three images of one surface: image i shows at (x, y) what the view has at (x, y) - e parallax_i.
struct Displaced {
  ProjectedImages images;
  Parallaxes parallaxes;
};

Displaced displaced(float e, const std::vector<std::array<float, 2>>& directions) {
  Displaced made;
  ProjectedImages& images = made.images;
  Parallaxes& parallaxes = made.parallaxes;
  images.width = parallaxes.width = kWidth;
  images.height = parallaxes.height = kHeight;
  for (const std::array<float, 2>& direction : directions) {
    std::vector<std::uint8_t> gray(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        gray[static_cast<std::size_t>(y * kWidth + x)] = static_cast<std::uint8_t>(
            wave(static_cast<float>(x) - e * direction[0], static_cast<float>(y) - e * direction[1]) + 0.5F);
    images.state.push_back(std::vector<std::uint8_t>(gray.size(), ProjectedImages::kOwn));
    parallaxes.x.push_back(std::vector<float>(gray.size(), direction[0]));
    parallaxes.y.push_back(std::vector<float>(gray.size(), direction[1]));
    parallaxes.offset.assign(gray.size(), 0.01F);
    parallaxes.share.push_back(1 / static_cast<float>(directions.size()));
    images.gray.push_back(std::move(gray));
  }
  return made;
}

const std::vector<std::array<float, 2>> kThree = {{-0.5F, 0.1F}, {0.6F, 0}, {0.1F, -0.4F}};

std::size_t middle() { return kHeight / 2 * kWidth + kWidth / 2; }

TEST(DepthFlow, FindsTheDisplacementThatAllImagesShare) {
  for (const float e : {-4.F, -0.5F, 1.F, 3.F}) {
    const Displaced d = displaced(e, kThree);
    DepthFlow flow;
    ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
    EXPECT_NEAR(flow.displacement()[middle()], e, 0.1) << e;
    EXPECT_GT(flow.believed()[middle()], 150) << e;
  }
}

TEST(DepthFlow, LeavesEqualImagesWhereTheyAre) {
  const Displaced d = displaced(0, kThree);
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
  EXPECT_THAT(flow.displacement(), testing::Each(testing::FloatNear(0, 0.05F)));
}

TEST(DepthFlow, TakesTwoImagesAndThoseOnALine) {
  for (const auto& directions :
       {std::vector<std::array<float, 2>>{{-0.5F, 0}, {0.5F, 0}}, {{-0.6F, 0}, {0.1F, 0}, {0.5F, 0}}}) {
    const Displaced d = displaced(2, directions);
    DepthFlow flow;
    ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
    EXPECT_NEAR(flow.displacement()[middle()], 2, 0.2) << directions.size();
  }
}

// An image that does not move along its parallax is no evidence, and of images without parallax none is.
TEST(DepthFlow, BelievesNothingThatMakesNoImagesMoreAlike) {
  Displaced d = displaced(3, kThree);
  for (std::vector<float>& plane : d.parallaxes.x) std::fill(plane.begin(), plane.end(), 0.F);
  for (std::vector<float>& plane : d.parallaxes.y) std::fill(plane.begin(), plane.end(), 0.F);
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
  EXPECT_THAT(flow.displacement(), testing::Each(testing::FloatNear(0, 1e-3F)));
}

TEST(DepthFlow, ContinuesWhereOneImageHasNoColorOfItsOwn) {
  Displaced d = displaced(2, {{-0.5F, 0}, {0.5F, 0}});
  for (int y = 40; y < 80; ++y)
    for (int x = 60; x < 90; ++x) {
      const auto i = static_cast<std::size_t>(y * kWidth + x);
      d.images.state[1][i] = ProjectedImages::kFilled;
      d.images.gray[1][i] = d.images.gray[0][i];
    }
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
  EXPECT_EQ(flow.believed()[60 * kWidth + 75], 0);
  EXPECT_NEAR(flow.displacement()[60 * kWidth + 75], 2, 0.5);
}

TEST(DepthFlow, HoldsNothingOffTheProxy) {
  Displaced d = displaced(2, kThree);
  for (std::size_t i = 0; i < 3; ++i)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < 40; ++x) {
        d.images.state[i][static_cast<std::size_t>(y * kWidth + x)] = ProjectedImages::kNoProxy;
        d.images.gray[i][static_cast<std::size_t>(y * kWidth + x)] = 0;
      }
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes, {}, 1), IsOk());
  EXPECT_EQ(flow.believed()[60 * kWidth + 20], 0);
  EXPECT_NEAR(flow.displacement()[60 * kWidth + 100], 2, 0.1);
}

TEST(DepthFlow, IsTheSameAtAnyNumberOfThreads) {
  const Displaced d = displaced(3, kThree);
  DepthFlow one, many;
  ASSERT_THAT(one.estimate(d.images, d.parallaxes, {}, 1), IsOk());
  for (const int threads : {2, 3, 8}) {
    ASSERT_THAT(many.estimate(d.images, d.parallaxes, {}, threads), IsOk());
    EXPECT_EQ(many.displacement(), one.displacement()) << threads;
    EXPECT_EQ(many.believed(), one.believed()) << threads;
  }
}

TEST(DepthFlow, StopsAtTheLevelThatItIsTold) {
  const Displaced d = displaced(3, kThree);
  FlowOptions coarse;
  coarse.finest_scale = 1;
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes, coarse, 2), IsOk());
  EXPECT_NEAR(flow.displacement()[middle()], 3, 0.2);
}

TEST(DepthFlow, RefusesWhatTheVariationalFlowDoesNotHave) {
  const Displaced d = displaced(0, kThree);
  FlowOptions wrong;
  wrong.preset = "ultrafast";
  EXPECT_THAT(DepthFlow().estimate(d.images, d.parallaxes, wrong, 1),
              FailsWith(ErrorCode::InvalidArgument, "ultrafast"));
}

class AlignmentByDepth : public OnEachBackEnd {
 protected:
  static RendererOptions by(Alignment alignment) {
    RendererOptions options;
    options.alignment = alignment;
    return options;
  }
  double score(const Image& picture) const {
    return psnr(picture, truth_.rgb,
                [&](int x, int y) { return *truth_.alpha.at(x, y) == 255 && well_inside(picture, x, y, 8); });
  }
  // The proxy is two centimetres too large.
  const Stage stage_ = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  const View view_ = view_at(6);
  const Photograph truth_ =
      photograph(ball(0.25F, 48), view_.model, view_.view_from_world, 3, random_checker(0.04F, 5));
};
FLOATSTAGE_ON_EACH_BACK_END(AlignmentByDepth);

TEST_P(AlignmentByDepth, ShowsTheSurfaceThatTheProxyMisses) {
  const double linear = score(rendered(stage_, view_, "linear")),
               fields = score(rendered(stage_, view_, "floating", by(Alignment::Flow))),
               depth = score(rendered(stage_, view_, "floating", by(Alignment::Depth)));
  EXPECT_GT(depth, linear + 3);
  EXPECT_GT(depth, fields - 1);
}

TEST_P(AlignmentByDepth, IsChosenWhereNoGpuFindsTheFlow) {
  const bool same = rendered(stage_, view_, "floating", by(Alignment::Auto)) ==
                    rendered(stage_, view_, "floating", by(Alignment::Depth));
  EXPECT_TRUE(same || GetParam() == render::BackEnd::Gl);
}

TEST_P(AlignmentByDepth, NeedsNoMoreThanOneCamera) {
  RendererOptions one = by(Alignment::Depth);
  one.cameras = 1;
  EXPECT_GT(rendered(stage_, view_at(0), "floating", one).width, 0);
}

TEST_P(AlignmentByDepth, FindsFieldsWhereThereIsNoParallaxToFollow) {
  RendererOptions none = by(Alignment::Depth), mean = by(Alignment::Depth), plain;
  none.flow.backend = plain.flow.backend = "none";
  EXPECT_EQ(rendered(stage_, view_, "floating", none), rendered(stage_, view_, "floating", plain));
  plain = {};
  mean.positions = plain.positions = Positions::Mean;
  EXPECT_EQ(rendered(stage_, view_, "floating", mean), rendered(stage_, view_, "floating", plain));
}

TEST_P(AlignmentByDepth, IsTheSameAtAnyNumberOfThreads) {
  RendererOptions one = by(Alignment::Depth), three = one;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(rendered(stage_, view_, "floating", one), rendered(stage_, view_, "floating", three));
}

// What is shown of it is this picture's, in this picture's size.
TEST_P(AlignmentByDepth, ShowsWhatItFound) {
  Scene scene;
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  for (const RenderOutput output : {RenderOutput::Confidence, RenderOutput::Field, RenderOutput::Flow,
                                    RenderOutput::Measured, RenderOutput::Warped}) {
    const std::unique_ptr<ViewRenderer> renderer = make("floating");
    RendererOptions options = by(Alignment::Depth);
    options.output = output;
    for (const int width : {64, 320, 160}) {
      const View view = view_at(6, 10, small_camera(width, width * 3 / 4));
      const Result<RenderedView> shown = renderer->render(scene, view, options);
      ASSERT_THAT(shown, IsOk());
      const Image picture = download(*shown);
      EXPECT_EQ(picture, rendered(stage_, view, "floating", options)) << width;
      const auto lit = [&] {
        for (std::size_t i = 0; i < picture.pixels.size(); i += 4)
          if (picture.pixels[i] + picture.pixels[i + 1] + picture.pixels[i + 2] > 0) return true;
        return false;
      };
      EXPECT_TRUE(lit()) << static_cast<int>(output);
    }
  }
}

TEST_P(AlignmentByDepth, WorksAtASmallerSize) {
  RendererOptions half = by(Alignment::Depth);
  half.flow.shrink = 2;
  EXPECT_GT(score(rendered(stage_, view_, "floating", half)), score(rendered(stage_, view_, "linear")) + 1.5);
}

// Noise in the photographs is found anew in each view; what is remembered trembles less.
TEST_P(AlignmentByDepth, RemembersWhatThePictureBeforeFound) {
  Stage noisy = stage_;
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0, 12);
  for (Frame& frame : noisy.scene.images.frames) {
    Image image = *to_rgb(frame);
    for (std::uint8_t& value : image.pixels)
      value = static_cast<std::uint8_t>(std::clamp(static_cast<float>(value) + noise(random), 0.F, 255.F));
    frame = make_frame(frame.info, image);
  }
  Scene scene;
  ASSERT_THAT(scene.set(noisy.rig, noisy.scene), IsOk());
  const auto walk = [&](double memory) {
    const std::unique_ptr<ViewRenderer> renderer = make("floating");
    RendererOptions options = by(Alignment::Depth);
    options.field_memory = memory;
    Image last;
    for (int step = 0; step < 6; ++step)
      last = download(*renderer->render(scene, view_at(5.5 + 0.1 * step), options));
    return last;
  };
  const Image alone = walk(0), remembered = walk(0.75);
  EXPECT_NE(alone, remembered);
  EXPECT_GT(score(remembered), score(alone) - 0.1);
}

TEST_P(AlignmentByDepth, ForgetsWhenTold) {
  Scene scene;
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  const std::unique_ptr<ViewRenderer> renderer = make("floating");
  RendererOptions options = by(Alignment::Depth);
  options.field_memory = 0.75;
  const Image first = download(*renderer->render(scene, view_, options));
  ASSERT_THAT(renderer->render(scene, view_at(7), options), IsOk());
  EXPECT_NE(download(*renderer->render(scene, view_, options)), first);
  renderer->reset_history();
  EXPECT_EQ(download(*renderer->render(scene, view_, options)), first);
}

// Another scene is another surface, however alike it is.
TEST_P(AlignmentByDepth, ForgetsAnotherScene) {
  Scene scene;
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  const std::unique_ptr<ViewRenderer> renderer = make("floating");
  RendererOptions options = by(Alignment::Depth);
  options.field_memory = 0.75;
  ASSERT_THAT(renderer->render(scene, view_at(7), options), IsOk());
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  EXPECT_EQ(download(*renderer->render(scene, view_, options)),
            rendered(stage_, view_, "floating", by(Alignment::Depth)));
}

class AlignmentOfBoth : public Rendering {};

TEST_F(AlignmentOfBoth, BackEndsDrawTheSamePicturesByDepth) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  constexpr RenderOutput kOutputs[] = {RenderOutput::Color, RenderOutput::Flow, RenderOutput::Field,
                                       RenderOutput::Confidence, RenderOutput::Measured};
  const auto draw = [&](render::BackEnd back_end) {
    open(back_end);
    std::vector<Image> pictures;
    for (const int shrink : {1, 2})
      for (const RenderOutput output : kOutputs) {
        RendererOptions options;
        options.alignment = Alignment::Depth;
        options.output = output;
        options.flow.shrink = shrink;
        pictures.push_back(rendered(stage, view_at(6), "floating", options));
      }
    return pictures;
  };
  const std::vector<Image> cpu = draw(render::BackEnd::Cpu), gl = draw(render::BackEnd::Gl);
  for (std::size_t i = 0; i < cpu.size(); ++i)
    EXPECT_GT(psnr(cpu[i], gl[i], [](int, int) { return true; }), i % 5 == 0 ? 45 : 28) << i;
}

}  // namespace
}  // namespace floatstage::render
