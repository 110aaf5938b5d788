// What no camera sees: it continues its surroundings, or fades where no picture reaches.
#include <algorithm>
#include <optional>

#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

constexpr double kRadius = 0.25;

/// Where a view's ray through a pixel first meets the ball.
std::optional<Eigen::Vector3d> on_ball(const View& view, int x, int y) {
  const CameraModel& m = view.model;
  const Eigen::Vector3d eye = view.view_from_world.center(),
                        ray = (view.view_from_world.rotation.inverse() *
                               Eigen::Vector3d((x + 0.5 - m.cx) / m.fx, (y + 0.5 - m.cy) / m.fy, 1))
                                  .normalized();
  const double along = ray.dot(eye), square = along * along - eye.squaredNorm() + kRadius * kRadius;
  if (square < 0) return std::nullopt;
  return eye + (-along - std::sqrt(square)) * ray;
}

/// The cosine between the ball's surface there and the way to the camera that looks most straight at it.
double most_facing(const Rig& rig, const Eigen::Vector3d& p) {
  double most = -1;
  for (const RigCamera& camera : rig.cameras)
    most = std::max(most, p.normalized().dot((camera.cam_from_world.center() - p).normalized()));
  return most;
}

Stage from_the_front() { return photographed(arc(3, 20), ball(kRadius, 48), ball(kRadius, 48), false); }
/// A little from the side: the ball's right quarter is what nobody sees.
View from_the_side() { return view_at(75); }

RendererOptions as_drawn() {
  RendererOptions options;
  options.soft_outlines = false;
  return options;
}

/// The largest step between neighbours of a row or column, in levels, where both are of `part`.
template <class Part>
int largest_step(const Image& picture, const Part& part) {
  int largest = 0;
  for (int y = 0; y + 1 < picture.height; ++y)
    for (int x = 0; x + 1 < picture.width; ++x)
      for (const auto& [u, v] : {std::pair{x + 1, y}, std::pair{x, y + 1}}) {
        if (!part(x, y) || !part(u, v)) continue;
        for (int c = 0; c < 3; ++c)
          largest = std::max(largest, std::abs(picture.at(x, y)[c] - picture.at(u, v)[c]));
      }
  return largest;
}

class WhatNobodySees : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(WhatNobodySees);

TEST_P(WhatNobodySees, ContinuesItsSurroundings) {
  const Stage stage = from_the_front();
  const View view = from_the_side();
  const auto facing = [&](int x, int y) {
    const auto p = on_ball(view, x, y);
    return p ? most_facing(stage.rig, *p) : -2;
  };
  const auto unseen = [&](int x, int y) { return facing(x, y) > -2 && facing(x, y) < -0.15; };
  const auto seen = [&](int x, int y) { return facing(x, y) > 0.3; };
  for (const std::string method : {"nearest", "linear", "floating"}) {
    const Image before = rendered(stage, view, method, as_drawn()), picture = rendered(stage, view, method);
    EXPECT_GT(largest_step(before, unseen), 60) << method << ": there is nothing to continue";
    EXPECT_LT(largest_step(picture, unseen), 12) << method;
    EXPECT_GT(largest_step(picture, seen), 60) << method << ": what is seen keeps its checker";
    const auto covered = [&](int x, int y) { return seen(x, y) && before.at(x, y)[3] == 255; };
    EXPECT_GT(psnr(picture, before, covered), 60) << method;
  }
}

TEST_P(WhatNobodySees, IsNothingWhereAllIsSeen) {
  const Stage stage = from_the_front();
  const Image before = rendered(stage, view_at(5), "linear", as_drawn()),
              picture = rendered(stage, view_at(5), "linear");
  EXPECT_GT(psnr(picture, before, [&](int x, int y) { return well_inside(before, x, y, 2); }), 90);
}

TEST_P(WhatNobodySees, IsCounted) {
  const Stage stage = from_the_front();
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = make("linear");
  const auto pixels = [&](const View& view, const RendererOptions& options = {}) {
    return seen_pixels(*renderer->render(scene, view, options));
  };
  const auto share = [](const SeenPixels& p) { return static_cast<double>(p.seen) / p.shown; };
  const Image drawn = rendered(stage, from_the_side(), "linear", as_drawn());
  std::uint32_t covered = 0, facing = 0;
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      const auto p = on_ball(from_the_side(), x, y);
      covered += drawn.at(x, y)[3] == 255;
      facing += p && most_facing(stage.rig, *p) > 0.05;
    }
  const SeenPixels from_the_side_seen = pixels(from_the_side());
  EXPECT_EQ(from_the_side_seen.shown, covered);
  EXPECT_NEAR(from_the_side_seen.seen, facing, 0.05 * covered);
  EXPECT_GT(share(pixels(view_at(5))), 0.97);
  EXPECT_LT(share(pixels(view_at(180, -10))), 0.2);
  EXPECT_EQ(pixels(from_the_side(), as_drawn()).shown, 0U) << "nothing is continued, and nobody asked";
  RendererOptions weights;
  weights.output = RenderOutput::Weights;
  EXPECT_EQ(pixels(from_the_side(), weights).shown, 0U);
}

// From behind there are no surroundings: what photographs show elsewhere is better than nothing.
TEST_P(WhatNobodySees, StaysWhereNobodySeesAnything) {
  const Stage stage = photographed(arc(1, 20), ball(kRadius, 48), ball(kRadius, 48), false);
  const Image before = rendered(stage, view_at(180, -10), "linear", as_drawn()),
              picture = rendered(stage, view_at(180, -10), "linear");
  EXPECT_GT(psnr(picture, before, [&](int x, int y) { return well_inside(before, x, y, 2); }), 90);
}

// Somebody of whom all pictures have the upper half.
TEST_P(WhatNobodySees, FadesWhereNoPictureReaches) {
  Stage stage = from_the_front();
  for (RigCamera& camera : stage.rig.cameras)
    camera.cam_from_world = look_at(camera.cam_from_world.center(), {0, 0, 0.3}, Eigen::Vector3d::UnitZ());
  stage = photographed(stage.rig, ball(kRadius, 48), ball(kRadius, 48), false);
  const View view = view_at(5);
  const Image picture = rendered(stage, view, "linear");
  int shown = 0, faded = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const auto p = on_ball(view, x, y);
      if (!p || p->head<2>().norm() < 0.1) continue;
      double lowest = 1e9, highest = -1e9;  // of the pictures, rows that show it
      for (const RigCamera& camera : stage.rig.cameras) {
        const double row = (camera.model.k() * (camera.cam_from_world * *p)).hnormalized().y();
        lowest = std::min(lowest, row), highest = std::max(highest, row);
      }
      if (highest < stage.rig.cameras[0].model.height - 4 && well_inside(picture, x, y, 3)) {
        EXPECT_EQ(picture.at(x, y)[3], 255) << x << ", " << y;
        ++shown;
      } else if (lowest > stage.rig.cameras[0].model.height + 4) {
        EXPECT_EQ(picture.at(x, y)[3], 0) << x << ", " << y;
        ++faded;
      }
    }
  EXPECT_GT(shown, 200);
  EXPECT_GT(faded, 200);
}

// Of the cameras about the view none has the lower half in its picture: whoever has it draws it, from far
// off.
TEST_P(WhatNobodySees, IsDrawnByWhoeverHasItInThePicture) {
  Rig rig = arc(9, 12);
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (i % 8 != 0)
      rig.cameras[i].cam_from_world =
          look_at(rig.cameras[i].cam_from_world.center(), {0, 0, 0.25}, Eigen::Vector3d::UnitZ());
  const Mesh mesh = ball(0.2F, 48);
  const Stage stage = photographed(rig, mesh, mesh);
  // From between cameras, from beside one, and from its own place, where it has all the weight.
  for (const double degrees : {3.0, 0.2, 0.0}) {
    const View view = view_at(degrees);
    const Photograph truth = photograph(mesh, view.model, view.view_from_world, 3, random_checker(0.04F, 5));
    const Image picture = rendered(stage, view, "linear");
    const auto half = [&](bool lower) {
      return psnr(picture, truth.rgb,
                  [&](int x, int y) { return (lower ? y > 75 : y < 60) && well_inside(picture, x, y, 3); });
    };
    EXPECT_GT(half(true), 20) << degrees;
    EXPECT_GT(half(false), 20) << degrees;
  }
}

TEST(WhatNobodySeesOnBothBackEnds, IsAlike) {
  class OnOne : public Rendering {
    void TestBody() override {}

   public:
    Image draw(BackEnd back_end) {
      open(back_end);
      return rendered(from_the_front(), from_the_side(), "floating");
    }
  };
  const Image cpu = OnOne().draw(BackEnd::Cpu), gl = OnOne().draw(BackEnd::Gl);
  EXPECT_GE(psnr(cpu, gl, [&](int x, int y) { return cpu.at(x, y)[3] > 0; }), 45);
}

}  // namespace
}  // namespace floatstage::render
