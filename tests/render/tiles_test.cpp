#include <algorithm>

#include "render/projected_images.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

using testing::Contains;
using testing::SizeIs;

/// One camera's photograph, cut down to the box around its subject.
struct Cut {
  int camera = 0, x = 0, y = 0;
  Image picture, matte;
  render::PictureTile tile() const { return {camera, x, y, &picture, &matte}; }
};

Cut cut(const Stage& stage, int camera, int border = 4) {
  const auto c = static_cast<std::size_t>(camera);
  const Image rgb = *to_rgb(stage.scene.images.frames[c]), alpha = to_image(stage.scene.mattes[c]);
  int x0 = alpha.width, y0 = alpha.height, x1 = 0, y1 = 0;
  for (int y = 0; y < alpha.height; ++y)
    for (int x = 0; x < alpha.width; ++x)
      if (*alpha.at(x, y) != 0)
        x0 = std::min(x0, x), y0 = std::min(y0, y), x1 = std::max(x1, x + 1), y1 = std::max(y1, y + 1);
  x0 = std::max(x0 - border, 0), y0 = std::max(y0 - border, 0);
  x1 = std::min(x1 + border, alpha.width), y1 = std::min(y1 + border, alpha.height);
  Cut out{camera, x0, y0, Image(x1 - x0, y1 - y0, 3), Image(x1 - x0, y1 - y0, 1)};
  for (int y = y0; y < y1; ++y) {
    std::copy_n(rgb.at(x0, y), 3 * (x1 - x0), out.picture.at(0, y - y0));
    std::copy_n(alpha.at(x0, y), x1 - x0, out.matte.at(0, y - y0));
  }
  return out;
}

class Tiles : public OnEachBackEnd {
 protected:
  Image rendered_from(const Stage& stage, const std::vector<Cut>& cuts, const View& view,
                      const RendererOptions& options) const {
    std::vector<render::PictureTile> tiles;
    for (const Cut& c : cuts) tiles.push_back(c.tile());
    render::Scene scene;
    EXPECT_THAT(scene.set(stage.rig, stage.scene.mesh, tiles), IsOk());
    const auto renderer = make("floating");
    const Result<RenderedView> picture = renderer->render(scene, view, options);
    EXPECT_THAT(picture, IsOk());
    return picture ? download(*picture) : Image{};
  }
};
FLOATSTAGE_ON_EACH_BACK_END(Tiles);

TEST_P(Tiles, OfTheNeededCamerasDrawWhatAllPhotographsDraw) {
  const Stage stage = photographed(arc(8, 20), ball(0.25F, 48), ball(0.25F, 48));
  for (double degrees : {-47.0, 3.0, 16.0, 66.0}) {
    const View view = view_at(degrees);
    const std::vector<int> needed = needed_cameras(stage.rig, stage.scene.mesh, view, 3);
    ASSERT_THAT(needed, SizeIs(3));
    std::vector<Cut> cuts;
    for (int camera : needed) cuts.push_back(cut(stage, camera));
    const Image whole = rendered(stage, view, "floating"), live = rendered_from(stage, cuts, view, {});
    const double agreement = psnr(live, whole, [&](int x, int y) { return well_inside(whole, x, y, 2); });
    EXPECT_GT(agreement, 40) << "from " << degrees << " degrees";
  }
}

TEST_P(Tiles, OfTheLastInstantStillDrawAViewThatHasMovedOn) {
  const Stage stage = photographed(arc(8, 20), ball(0.25F, 48), ball(0.25F, 24));
  std::vector<Cut> cuts;
  for (int camera : needed_cameras(stage.rig, stage.scene.mesh, view_at(0), 3))
    cuts.push_back(cut(stage, camera));
  const View moved = view_at(35);
  const Image whole = rendered(stage, moved, "floating"), live = rendered_from(stage, cuts, moved, {});
  EXPECT_GT(psnr(live, whole, [&](int x, int y) { return well_inside(whole, x, y, 2); }), 14);
}

TEST_P(Tiles, MayChangeTheirSizeFromInstantToInstant) {
  const Stage stage = photographed(arc(3, 20), ball(0.25F, 48), ball(0.25F, 24));
  render::Scene scene;
  const auto renderer = make("linear");
  Image first;
  for (int border : {4, 60, 4}) {
    std::vector<Cut> cuts;
    std::vector<render::PictureTile> tiles;
    for (int camera = 0; camera < 3; ++camera) cuts.push_back(cut(stage, camera, border));
    for (const Cut& c : cuts) tiles.push_back(c.tile());
    ASSERT_THAT(scene.set(stage.rig, stage.scene.mesh, tiles), IsOk());
    const Image picture = download(*renderer->render(scene, view_at(5), {}));
    if (first.empty()) first = picture;
    EXPECT_GT(psnr(picture, first, [](int, int) { return true; }), 50)
        << "with a border of " << border << " px";
  }
}

TEST_P(Tiles, ThatFitNoPhotographAreRefused) {
  const Stage stage = photographed(arc(3, 20), ball(0.25F, 24), ball(0.25F, 24));
  render::Scene scene;
  const Cut good = cut(stage, 1);
  render::PictureTile outside = good.tile(), unknown = good.tile(), torn = good.tile();
  outside.x = 159;
  unknown.camera = 3;
  const Image small(2, 2, 1);
  torn.matte = &small;
  for (const render::PictureTile& bad : {outside, unknown, torn}) {
    const std::vector<render::PictureTile> tiles = {bad};
    EXPECT_THAT(scene.set(stage.rig, stage.scene.mesh, tiles), FailsWith(ErrorCode::InvalidArgument, "tile"));
  }
  const std::vector<render::PictureTile> twice = {good.tile(), good.tile()};
  EXPECT_THAT(scene.set(stage.rig, stage.scene.mesh, twice),
              FailsWith(ErrorCode::InvalidArgument, "has one already"));
  EXPECT_THAT(scene.set(stage.rig, stage.scene.mesh, {}), FailsWith(ErrorCode::InvalidArgument, "no camera"));
}

TEST_P(Tiles, WithAFlowAtHalfSizeStayNearTheFullOne) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 48), ball(0.27F, 24));
  const Image full = rendered(stage, view_at(7), "floating"), linear = rendered(stage, view_at(7), "linear");
  RendererOptions half;
  half.flow.shrink = 2;
  const Image coarse = rendered(stage, view_at(7), "floating", half);
  const auto inside = [&](int x, int y) { return well_inside(full, x, y, 3); };
  EXPECT_GT(psnr(coarse, full, inside), psnr(linear, full, inside) + 3);
}

TEST(FlowSize, MustBeAFractionThatLeavesSomething) {
  RendererOptions options;
  for (int shrink : {0, -1, 9}) {
    options.flow.shrink = shrink;
    EXPECT_THAT(check(options), FailsWith(ErrorCode::InvalidArgument, "flow"));
  }
}

// The photographs of those that stand in are asked for only where they are shown.
TEST(NeededCameras, AreMoreWhereTheNearestOnesLackSomebody) {
  Rig rig = arc(8, 20);
  const auto turn = [](RigCamera& camera, const Eigen::Vector3d& towards) {
    camera.cam_from_world = look_at(camera.cam_from_world.center(), towards, Eigen::Vector3d::UnitZ());
  };
  for (std::size_t i = 0; i < 3; ++i) turn(rig.cameras[i], {0, 0, -0.3});  // the ball's upper half is cut off
  const std::vector<int> needed = needed_cameras(rig, ball(0.25F), view_at(-45), 3);
  ASSERT_THAT(needed, SizeIs(6));
  EXPECT_EQ(std::vector<int>(needed.begin(), needed.begin() + 3), (std::vector<int>{1, 2, 0}));
  EXPECT_THAT(needed, testing::Contains(3));
}

TEST(NeededCameras, AreTheNearestByAngleStrongestFirst) {
  const Rig rig = arc(8, 20);  // at -70, -50, … 70 degrees
  const std::vector<int> needed = needed_cameras(rig, ball(0.25F), view_at(-45), 3);
  EXPECT_EQ(needed, (std::vector<int>{1, 2, 0}));
  EXPECT_THAT(needed_cameras(rig, ball(0.25F), view_at(0), 20), SizeIs(8)) << "never more than there are";
  EXPECT_THAT(needed_cameras(rig, Mesh{}, view_at(0), 3), SizeIs(3))
      << "before there is a subject, any will do";
}

TEST(ProjectedImages, ShrunkPixelsAreOwnOnlyWhereAllOfThemAre) {
  // 4 x 2 px: own, own, filled, own / own, none, none, none
  const std::vector<std::uint8_t> rgba = {10, 10, 10, 255, 30, 30, 30, 255, 50, 50, 50, 128, 90, 90, 90, 255,
                                          20, 20, 20, 255, 0,  0,  0,  0,   0,  0,  0,  0,   0,  0,  0,  0};
  const ProjectedImages half = projected_images(rgba, 4, 2, 1, 2);
  ASSERT_EQ(half.width, 2);
  ASSERT_EQ(half.height, 1);
  EXPECT_EQ(half.gray[0], (std::vector<std::uint8_t>{20, 70})) << "what is not on the proxy does not count";
  EXPECT_EQ(half.state[0][0], ProjectedImages::kOwn);
  EXPECT_EQ(half.state[0][1], ProjectedImages::kFilled);
  const ProjectedImages odd = projected_images(rgba, 4, 2, 1, 3);
  EXPECT_EQ(odd.width, 2);
  EXPECT_EQ(odd.state[0][1], ProjectedImages::kOwn);
}

}  // namespace
}  // namespace floatstage::render
