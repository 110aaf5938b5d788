#include <algorithm>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

class Floating : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(Floating);

/// A large square in the plane x = 0, facing the cameras at positive x.
Mesh wall(float half) {
  Mesh mesh;
  mesh.positions = {{0, -half, -half}, {0, half, -half}, {0, half, half}, {0, -half, half}};
  mesh.triangles = {0, 1, 2, 0, 2, 3};
  return mesh;
}

struct Spot {
  double x = 0, y = 0, mass = 0;
};

/// Centre and mass of the pixels of the covered picture that are brighter than the backdrop.
Spot bright_spot(const Image& picture, int backdrop) {
  Spot spot;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (picture.at(x, y)[3] == 0) continue;
      const double m = std::max(0, picture.at(x, y)[1] - backdrop - 8);
      spot.x += m * (x + 0.5);
      spot.y += m * (y + 0.5);
      spot.mass += m;
    }
  spot.x /= spot.mass;
  spot.y /= spot.mass;
  return spot;
}

constexpr int kBackdrop = 40;

/// Two cameras look at a wall; each photograph shows a soft bright square, displaced by `shift` px from where
/// the geometry says, to the left in one photograph and to the right in the other.
Stage misprojected_square(double shift) {
  CameraModel model = small_camera(200, 160);
  Stage stage{arc(2, 10, model), {}};
  for (int c = 0; c < 2; ++c) {
    const RigCamera& camera = stage.rig.cameras[static_cast<std::size_t>(c)];
    const Eigen::Vector2d center = *project(model, camera.cam_from_world * Eigen::Vector3d::Zero()) +
                                   Eigen::Vector2d(c == 0 ? -shift : shift, 0);
    Image photo(model.width, model.height, 3, kBackdrop);
    for (int y = 0; y < model.height; ++y)
      for (int x = 0; x < model.width; ++x) {
        const double inside = 12.5 - std::max(std::abs(x + 0.5 - center.x()), std::abs(y + 0.5 - center.y()));
        const auto value = static_cast<std::uint8_t>(kBackdrop + 180 * std::clamp(inside, 0.0, 1.0));
        std::fill_n(photo.at(x, y), 3, value);
      }
    FrameInfo info;
    info.camera = c;
    stage.scene.images.frames.push_back(make_frame(info, photo));
  }
  stage.scene.mesh = wall(0.2F);
  return stage;
}

TEST_P(Floating, AMisprojectedSquareAppearsOnceAtTheMeanPosition) {
  const Stage stage = misprojected_square(4);
  const View view = view_at(0, 10, small_camera(200, 160));
  const Image linear = rendered(stage, view, "linear"), floating = rendered(stage, view, "floating");
  const Spot spot = bright_spot(floating, kBackdrop);
  EXPECT_NEAR(spot.x, 100, 0.4);
  EXPECT_NEAR(spot.y, 80, 0.4);
  // Once: as large as one square (25 px wide), where the ghosts of the linear blend cover 33 px.
  auto width_at_half = [](const Image& picture) {
    int width = 0;
    for (int x = 0; x < picture.width; ++x)
      width += picture.at(x, 80)[1] > kBackdrop + 45 && picture.at(x, 80)[3] > 0;
    return width;
  };
  EXPECT_NEAR(width_at_half(floating), 25, 2);
  EXPECT_GE(width_at_half(linear), 31) << "the photographs do not disagree: nothing is tested";
}

TEST_P(Floating, TheMeanPositionFollowsTheWeights) {
  const Stage stage = misprojected_square(4);
  const CameraModel model = small_camera(200, 160);
  // At a camera the square is where that photograph has it; in between it moves steadily from one to the
  // other.
  double before = -1e9;
  std::vector<double> offsets;
  for (double degrees : {-4.9, -2.5, 0.0, 2.5, 4.9}) {
    const View view = view_at(degrees, 10, model);
    const double geometry = project(model, view.view_from_world * Eigen::Vector3d::Zero())->x();
    const double offset = bright_spot(rendered(stage, view, "floating"), kBackdrop).x - geometry;
    EXPECT_GT(offset, before - 0.2) << "at " << degrees;
    before = offset;
    offsets.push_back(offset);
  }
  EXPECT_NEAR(offsets.front(), -4, 0.7);
  EXPECT_NEAR(offsets.back(), 4, 0.7);
}

TEST_P(Floating, IdenticalProjectionsDoNotMoveAndBlendAsBefore) {
  Stage stage = photographed(arc(1, 0), ball(0.25F, 48), ball(0.265F, 24));
  stage.rig.cameras.push_back(stage.rig.cameras[0]);
  stage.rig.cameras[1].serial = "twin";
  stage.scene.images.frames.push_back(stage.scene.images.frames[0]);
  stage.scene.mattes.push_back(stage.scene.mattes[0]);
  const Image linear = rendered(stage, view_at(6), "linear"),
              floating = rendered(stage, view_at(6), "floating");
  for (std::size_t i = 0; i < linear.pixels.size(); ++i) ASSERT_NEAR(linear.pixels[i], floating.pixels[i], 1);
  render::RendererOptions options;
  options.output = RenderOutput::Flow;
  const Image flow = rendered(stage, view_at(6), "floating", options);
  for (std::size_t i = 0; i < flow.pixels.size(); i += 4) {
    if (flow.pixels[i + 3] == 0) continue;
    for (std::size_t c = 0; c < 3; ++c)
      ASSERT_EQ(flow.pixels[i + c], 255) << "a warp where there should be none";
  }
}

TEST_P(Floating, IsNearerToTheTruthThanLinearWhenTheProxyIsWrong) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.265F, 24));
  const View view = view_at(10);
  const Photograph truth =
      photograph(ball(0.25F, 48), view.model, view.view_from_world, 3, random_checker(0.04F, 5));
  auto score = [&](const char* method) {
    const Image picture = rendered(stage, view, method);
    return psnr(picture, truth.rgb,
                [&](int x, int y) { return *truth.alpha.at(x, y) == 255 && picture.at(x, y)[3] > 0; });
  };
  EXPECT_GT(score("floating"), score("linear") + 1);
}

TEST_P(Floating, TheNumberOfThreadsDoesNotChangeAByte) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.265F, 24));
  render::RendererOptions one, two;
  one.threads = 1;
  two.threads = 2;
  EXPECT_EQ(rendered(stage, view_at(7), "floating", one), rendered(stage, view_at(7), "floating", two));
}

TEST_P(Floating, WorksWithASingleCamera) {
  const Stage stage = photographed(arc(1, 20), ball(0.25F, 24), ball(0.25F, 24));
  const Image linear = rendered(stage, view_at(4), "linear"),
              floating = rendered(stage, view_at(4), "floating");
  for (std::size_t i = 0; i < linear.pixels.size(); ++i) ASSERT_NEAR(linear.pixels[i], floating.pixels[i], 2);
}

}  // namespace
}  // namespace floatstage::render
