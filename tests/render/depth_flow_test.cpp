// One depth a pixel for all photographs at once (RendererOptions::depth_share).
#include "render/depth_flow.h"

#include <cmath>
#include <limits>

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
    ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
    EXPECT_NEAR(flow.displacement()[middle()], e, 0.1) << e;
    EXPECT_GT(flow.believed()[middle()], 150) << e;
  }
}

TEST(DepthFlow, LeavesEqualImagesWhereTheyAre) {
  const Displaced d = displaced(0, kThree);
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
  EXPECT_THAT(flow.displacement(), testing::Each(testing::FloatNear(0, 0.05F)));
}

TEST(DepthFlow, TakesTwoImagesAndThoseOnALine) {
  for (const auto& directions :
       {std::vector<std::array<float, 2>>{{-0.5F, 0}, {0.5F, 0}}, {{-0.6F, 0}, {0.1F, 0}, {0.5F, 0}}}) {
    const Displaced d = displaced(2, directions);
    DepthFlow flow;
    ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
    EXPECT_NEAR(flow.displacement()[middle()], 2, 0.2) << directions.size();
  }
}

// An image that does not move along its parallax is no evidence, and of images without parallax none is.
TEST(DepthFlow, BelievesNothingThatMakesNoImagesMoreAlike) {
  Displaced d = displaced(3, kThree);
  for (std::vector<float>& plane : d.parallaxes.x) std::fill(plane.begin(), plane.end(), 0.F);
  for (std::vector<float>& plane : d.parallaxes.y) std::fill(plane.begin(), plane.end(), 0.F);
  DepthFlow flow;
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
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
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
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
  ASSERT_THAT(flow.estimate(d.images, d.parallaxes), IsOk());
  EXPECT_EQ(flow.believed()[60 * kWidth + 20], 0);
  EXPECT_NEAR(flow.displacement()[60 * kWidth + 100], 2, 0.1);
}

class DepthShares : public OnEachBackEnd {
 protected:
  static RendererOptions sharing(double share) {
    RendererOptions options;
    options.depth_share = share;
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
FLOATSTAGE_ON_EACH_BACK_END(DepthShares);

TEST_P(DepthShares, ShowTheSurfaceThatTheProxyMisses) {
  const double linear = score(rendered(stage_, view_, "linear")),
               fields = score(rendered(stage_, view_, "floating", sharing(0)));
  for (const double share : {0.5, 1.0}) {
    const double both = score(rendered(stage_, view_, "floating", sharing(share)));
    EXPECT_GT(both, linear + 3) << share;
    EXPECT_GT(both, fields - 1) << share;
  }
}

TEST_P(DepthShares, AreRefusedBeyondNoneAndAll) {
  Scene scene;
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  const std::unique_ptr<ViewRenderer> renderer = make("floating");
  for (const double share : {-0.1, 1.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(renderer->render(scene, view_, sharing(share)),
                FailsWith(ErrorCode::InvalidArgument, "depth share"));
}

TEST_P(DepthShares, NeedNoMoreThanOneCamera) {
  RendererOptions one = sharing(0.5);
  one.cameras = 1;
  EXPECT_GT(rendered(stage_, view_at(0), "floating", one).width, 0);
}

TEST_P(DepthShares, CountForNothingWithoutFieldsOrParallax) {
  RendererOptions none = sharing(0.5), mean = sharing(0.5), plain;
  none.flow.backend = plain.flow.backend = "none";
  EXPECT_EQ(rendered(stage_, view_, "floating", none), rendered(stage_, view_, "floating", plain));
  plain = {};
  mean.positions = plain.positions = Positions::Mean;
  EXPECT_EQ(rendered(stage_, view_, "floating", mean), rendered(stage_, view_, "floating", plain));
}

TEST_P(DepthShares, AreTheSameAtAnyNumberOfThreads) {
  for (const double share : {0.5, 1.0}) {
    RendererOptions one = sharing(share), three = sharing(share);
    one.threads = 1;
    three.threads = 3;
    EXPECT_EQ(rendered(stage_, view_, "floating", one), rendered(stage_, view_, "floating", three)) << share;
  }
}

// What is believed is this picture's, in this picture's size.
TEST_P(DepthShares, SayWhatIsBelievedOfThem) {
  Scene scene;
  ASSERT_THAT(scene.set(stage_.rig, stage_.scene), IsOk());
  for (const double share : {0.5, 1.0}) {
    const std::unique_ptr<ViewRenderer> renderer = make("floating");
    RendererOptions options = sharing(share);
    options.output = RenderOutput::Confidence;
    for (const int width : {64, 320, 160}) {
      const View view = view_at(6, 10, small_camera(width, width * 3 / 4));
      const Result<RenderedView> shown = renderer->render(scene, view, options);
      ASSERT_THAT(shown, IsOk());
      EXPECT_EQ(download(*shown), rendered(stage_, view, "floating", options)) << share << ", " << width;
    }
  }
}

TEST_P(DepthShares, WorkAtASmallerSizeOfFields) {
  RendererOptions half = sharing(0.5);
  half.flow.shrink = 2;
  EXPECT_GT(score(rendered(stage_, view_, "floating", half)), score(rendered(stage_, view_, "linear")) + 1.5);
}

class DepthSharesOfBoth : public Rendering {};

TEST_F(DepthSharesOfBoth, BackEndsDrawTheSamePictures) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  constexpr double kShares[] = {0.5, 1.0};
  const auto draw = [&](render::BackEnd back_end) {
    open(back_end);
    std::vector<Image> pictures;
    for (const double share : kShares) {
      RendererOptions options;
      options.depth_share = share;
      pictures.push_back(rendered(stage, view_at(6), "floating", options));
    }
    return pictures;
  };
  const std::vector<Image> cpu = draw(render::BackEnd::Cpu), gl = draw(render::BackEnd::Gl);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_GT(psnr(cpu[i], gl[i], [](int, int) { return true; }), 45) << kShares[i];
}

}  // namespace
}  // namespace floatstage::render
