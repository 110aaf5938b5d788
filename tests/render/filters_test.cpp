// Band-limited and filtered photographs against their definitions.
#include "render/band_limit.h"
#include "render/mitchell.h"
#include "render/photo_pyramid.h"
#include "tests/render/walls.h"

namespace floatstage::render {
namespace {

SceneTile spotted(int width, int height) {
  SceneTile tile;
  tile.resize(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = tile.at(x, y);
      p[0] = static_cast<std::uint8_t>((37 * x + 91 * y) % 256);
      p[1] = static_cast<std::uint8_t>((x * y) % 256);
      p[2] = static_cast<std::uint8_t>(x < width / 2 ? 250 : 5);
      p[3] = static_cast<std::uint8_t>(x + y < width ? 255 : 128 - 128 * (y % 2));
    }
  tile.repeat_border();
  return tile;
}

int largest_difference(const SceneTile& a, const SceneTile& b) {
  int most = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
  return most;
}

TEST(Mitchell, IsAPartitionOfUnityAndEndsAtTwo) {
  for (float at = 0; at < 1; at += 0.1F) {
    float sum = 0;
    for (int i = -3; i <= 3; ++i) sum += mitchell(at + static_cast<float>(i));
    EXPECT_NEAR(sum, 1, 1e-5) << at;
  }
  EXPECT_EQ(mitchell(2), 0);
  EXPECT_NEAR(mitchell(0), 16.0 / 18, 1e-6);
}

TEST(BandLimit, IsTheFilterOfItsDefinition) {
  for (const double width : {5.0, 12.0, 31.0}) {
    SceneTile fast = spotted(41, 23), slow = fast;
    band_limit(fast, width);
    band_limit_reference(slow, width);
    EXPECT_LE(largest_difference(fast, slow), 1) << width;
  }
}

TEST(BandLimit, LeavesPicturesAsTheyAreBelowThePixelsOwnFilter) {
  SceneTile tile = spotted(20, 20);
  const SceneTile before = tile;
  band_limit(tile, 4);
  EXPECT_EQ(largest_difference(tile, before), 0);
}

TEST(BandLimit, LetsNoBackdropIntoTheSubject) {
  SceneTile tile;
  tile.resize(40, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) {
      const bool subject = x < 20;
      const std::uint8_t rgba[4] = {static_cast<std::uint8_t>(subject ? 100 : 255), 50, 50,
                                    static_cast<std::uint8_t>(subject ? 255 : 0)};
      std::copy_n(rgba, 4, tile.at(x, y));
    }
  band_limit(tile, 16);
  for (int x = 0; x < 20; ++x) EXPECT_EQ(tile.at(x, 10)[0], 100) << x;
}

TEST(BandLimit, FollowsFromTheDepthRange) {
  const Stage stage = before_a_wall(3, 3);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.cameras = 2;
  options.nearest = 0.8;
  options.farthest = 1.25;
  // Eq. 9.13: of f b (1/0.8 - 1/1.25) px between the ends, a half on each side of the best plane, four times
  // it.
  const double disparity = 0.5 * 240 * 0.1 * (1 / 0.8 - 1 / 1.25);
  EXPECT_NEAR(band_limit_of(scene.impl(), 4, options), 4 * disparity, 1e-6);
  options.band_limit = 7;
  EXPECT_EQ(band_limit_of(scene.impl(), 4, options), 7);
  options = {};
  options.uncertainty = 0;
  EXPECT_EQ(band_limit_of(scene.impl(), 4, options), 0) << "an exact proxy needs no filter";
}

TEST(PhotoPyramid, HalvesColoursByTheirOpacity) {
  const Stage stage = photographed(arc(2, 20), ball(0.25F), ball(0.25F));
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const int both[] = {0, 1};
  const PhotoPyramid& pyramid = PhotoPyramid::of(scene.impl(), both);
  EXPECT_EQ(pyramid.levels[0][0].width, 80);
  EXPECT_EQ(pyramid.levels[4][1].width, 5);
  EXPECT_EQ(pyramid.levels[4][1].height, 4);
  EXPECT_EQ(pyramid_level(64), 0);
  EXPECT_EQ(pyramid_level(65), 1);
  EXPECT_EQ(pyramid_level(1e6F), 5);
}

class Filters : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(Filters);

// One photograph filtered along its line of disparity, from the definition: many samples, no pyramid; slow.
Image filtered_by_definition(const Stage& stage, std::size_t camera, const View& view, double error) {
  Image picture(view.model.width, view.model.height, 4);
  const Image photograph = *to_rgb(stage.scene.images.frames[camera]);
  const RigCamera& c = stage.rig.cameras[camera];
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const WallPoint at = on_wall(view, x, y);
      if (std::abs(at.place.x()) > 0.45 || std::abs(at.place.z()) > 0.35) continue;
      const Eigen::Vector2d p1 = *project(c.model, c.cam_from_world * (at.place - error * at.way)),
                            p2 = *project(c.model, c.cam_from_world * (at.place + error * at.way));
      const Eigen::Vector2d middle = 0.5 * (p1 + p2), way = p2 - p1;
      Eigen::Array3d sum = Eigen::Array3d::Zero();
      double total = 0;
      constexpr int kSamples = 400;
      for (int i = 0; i < kSamples; ++i) {
        const double s = 4 * (i + 0.5) / kSamples - 2, w = mitchell(static_cast<float>(s));
        sum += w * read(photograph, middle + s * way);
        total += w;
      }
      put(sum / total, picture.at(x, y));
    }
  return picture;
}

TEST_P(Filters, AreLaidAlongTheLineOfDisparity) {
  const Stage stage = before_a_wall(2, 2);
  const View view = view_from(0.12, -0.04);
  RendererOptions options;
  options.cameras = 1;
  options.sharp = false;
  const double diagonal = std::hypot(0.9, 0.7);
  for (const double uncertainty : {0.005, 0.03, 0.1}) {
    options.uncertainty = uncertainty;
    const Image found = rendered(stage, view, "filtered", options, {false, false, true, false});
    const Image wanted = filtered_by_definition(stage, 2, view, uncertainty * diagonal);
    EXPECT_GT(psnr(found, wanted,
                   [&](int x, int y) {
                     return well_inside(wanted, x, y, 2) && well_inside(found, x, y, 2) && x > 30 && x < 130;
                   }),
              38)
        << uncertainty;
  }
}

TEST_P(Filters, LeaveACamerasPhotographWhereThatCameraStandsButForBandLimits) {
  const Stage stage = before_a_wall(2, 3);
  RendererOptions options;
  options.uncertainty = 0.1;
  for (const std::size_t camera : {0u, 4u}) {
    const Image photograph = *to_rgb(stage.scene.images.frames[camera]);
    auto score = [&](const char* method) {
      const Image found = rendered(stage, view_of(stage.rig.cameras[camera]), method, options);
      return psnr(found, photograph, [&](int x, int y) { return well_inside(found, x, y, 3); });
    };
    EXPECT_GT(score("filtered"), 45);
    EXPECT_LT(score("band-limited"), 25);
  }
}

TEST_P(Filters, HideGhostsAndBandLimitsHideMore) {
  const Stage stage = before_a_wall(1, 4, 0.2F);
  RendererOptions options;
  options.uncertainty = 0.2 / std::hypot(0.9, 0.7);  // as far as the wall is before its proxy
  const View view = view_from(0.04, 0);
  options.output = RenderOutput::Ghosting;
  auto ghosts = [&](const char* method) {
    const Image heat = rendered(stage, view, method, options);
    double sum = 0;
    for (std::size_t i = 0; i < heat.pixels.size(); ++i)
      if (i % 4 != 3) sum += heat.pixels[i];
    return sum;
  };
  const double linear = ghosts("linear"), filtered = ghosts("filtered"), limited = ghosts("band-limited");
  EXPECT_LT(filtered, 0.95 * linear);
  EXPECT_LT(limited, filtered);
}

TEST_P(Filters, BlurMotionAndConvergeWhereTheViewRests) {
  const Stage stage = before_a_wall(2, 2);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = make("filtered");
  auto drawn = [&](double x, double blur) {
    RendererOptions options;
    options.motion_blur = blur;
    return download(*renderer->render(scene, view_from(x, 0), options));
  };
  const Image still = drawn(0.03, 0);
  EXPECT_EQ(drawn(0.03, 0.5), still) << "the first picture has none before it";
  const Image moved = drawn(0, 0.5);
  EXPECT_NE(moved, drawn(0, 0));
  drawn(0.03, 0.5);
  drawn(0, 0.5);
  Image last;
  for (int i = 0; i < 20; ++i) last = drawn(0, 0.5);
  EXPECT_EQ(last, drawn(0, 0)) << "the view rested";
  drawn(0.03, 0.5);
  renderer->reset_history();
  EXPECT_EQ(drawn(0, 0.5), last) << "what was before is forgotten";
}

TEST_P(Filters, RefuseWhatCannotBe) {
  const Stage stage = before_a_wall(2, 2);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  for (const char* method : {"band-limited", "filtered"}) {
    const auto renderer = make(method);
    auto refused = [&](auto change, const char* word) {
      RendererOptions options;
      change(options);
      EXPECT_THAT(renderer->render(scene, view_from(0, 0), options),
                  FailsWith(ErrorCode::InvalidArgument, word));
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    refused([&](RendererOptions& o) { o.uncertainty = nan; }, "uncertainty");
    refused([](RendererOptions& o) { o.uncertainty = 2; }, "uncertainty");
    refused([&](RendererOptions& o) { o.band_limit = nan; }, "band limit");
    refused([](RendererOptions& o) { o.nearest = 2, o.farthest = 1; }, "nearest < farthest");
    refused([](RendererOptions& o) { o.nearest = 1, o.farthest = 1; }, "nearest < farthest");
    refused([](RendererOptions& o) { o.motion_blur = 1; }, "motion blur");
    refused([](RendererOptions& o) { o.output = RenderOutput::Flow; }, "flow");
  }
}

}  // namespace
}  // namespace floatstage::render
