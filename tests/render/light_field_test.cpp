// Quadrilinear interpolation against its definition, pixel by pixel.
#include "tests/render/walls.h"

namespace floatstage::render {
namespace {

class LightField : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(LightField);

// The cameras of camera_wall(rows, columns) around a ray, weighted bilinearly; slow.
Image quadrilinear(const Stage& stage, const View& view, int rows, int columns) {
  Image picture(view.model.width, view.model.height, 4);
  std::vector<Image> photographs;
  for (const Frame& frame : stage.scene.images.frames) photographs.push_back(*to_rgb(frame));
  const Eigen::Vector3d eye = view.view_from_world.center();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const WallPoint at = on_wall(view, x, y);
      if (std::abs(at.place.x()) > 0.45 || std::abs(at.place.z()) > 0.35) continue;
      const Eigen::Vector3d on_plane = eye + at.way * ((-1 - eye.y()) / at.way.y());
      const double s = std::clamp(on_plane.x() / 0.1 + 0.5 * (columns - 1), 0.0, columns - 1.0),
                   t = std::clamp(-on_plane.z() / 0.1 + 0.5 * (rows - 1), 0.0, rows - 1.0);
      Eigen::Array3d sum = Eigen::Array3d::Zero();
      double total = 0;
      for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
          const double w = std::max(0.0, 1 - std::abs(s - column)) * std::max(0.0, 1 - std::abs(t - row));
          if (w == 0) continue;
          const auto i = static_cast<std::size_t>(row * columns + column);
          const RigCamera& camera = stage.rig.cameras[i];
          const Eigen::Vector2d p = *project(camera.model, camera.cam_from_world * at.place);
          const double counts = inside(camera.model, p) ? w : 1e-6 * w;
          sum += counts * read(photographs[i], p);
          total += counts;
        }
      put(sum / total, picture.at(x, y));
    }
  return picture;
}

TEST_P(LightField, IsQuadrilinearFromTheCamerasPlaneAndFromBehindAndBeforeIt) {
  const Stage stage = before_a_wall(3, 4);
  RendererOptions options;
  options.sharp = false;  // bilinear in the photographs
  for (const double back : {0.0, 0.4, -0.3})
    for (const auto& [x, z] : {std::pair(0.03, 0.02), std::pair(-0.11, 0.06)}) {
      const View view = view_from(x, z, back);
      const Image found = rendered(stage, view, "light-field", options),
                  wanted = quadrilinear(stage, view, 3, 4);
      EXPECT_GT(psnr(found, wanted, [&](int u, int v) { return well_inside(wanted, u, v, 2); }), 45)
          << back << " m back, at " << x << ", " << z;
    }
}

TEST_P(LightField, ReturnsACamerasPhotographWhereThatCameraStands) {
  const Stage stage = before_a_wall(3, 3);
  for (const std::size_t camera : {0u, 4u, 7u}) {
    const Image found = rendered(stage, view_of(stage.rig.cameras[camera]), "light-field");
    const Image photograph = *to_rgb(stage.scene.images.frames[camera]);
    EXPECT_GT(psnr(found, photograph, [&](int x, int y) { return well_inside(found, x, y, 2); }), 45);
  }
}

TEST_P(LightField, FloatsOnItsFourCameras) {
  const Stage stage = before_a_wall(2, 2, 0.05F);
  const View view = view_from(0, 0);
  RendererOptions options;
  options.cameras = 4;
  const Photograph truth =
      photograph(wall_at(-0.05F), view.model, view.view_from_world, 3, random_checker(0.04F, 5));
  auto score = [&](const char* method) {
    const Image picture = rendered(stage, view, method, options);
    return psnr(picture, truth.rgb, [&](int x, int y) { return well_inside(picture, x, y, 12); });
  };
  EXPECT_GT(score("floating"), score("light-field") + 4);
}

TEST_P(LightField, IsRefusedWhereThereIsNoGrid) {
  const Stage stage = before_a_wall(2, 3);
  render::Scene scene;
  const auto renderer = make("light-field");
  ASSERT_THAT(scene.set(stage.rig, stage.scene, {true, true, true, true, false, true}), IsOk());
  EXPECT_THAT(renderer->render(scene, view_from(0, 0), {}),
              FailsWith(ErrorCode::InvalidArgument, "places have no camera"));
  ASSERT_THAT(scene.set(stage.rig, stage.scene, {true, true, true, false, false, false}), IsOk());
  EXPECT_THAT(renderer->render(scene, view_from(0, 0), {}), FailsWith(ErrorCode::InvalidArgument, "only 3"));
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  RendererOptions options;
  options.output = RenderOutput::Weights;
  EXPECT_THAT(renderer->render(scene, view_from(0, 0), options),
              FailsWith(ErrorCode::InvalidArgument, "choose color"));
}

TEST_P(LightField, NamesTheFourCamerasItIsMadeFromStrongestFirst) {
  const Stage stage = before_a_wall(3, 3);
  render::Scene scene;
  ASSERT_THAT(scene.set(stage.rig, stage.scene), IsOk());
  const auto renderer = make("light-field");
  const Result<RenderedView> picture = renderer->render(scene, view_from(0.02, 0.03), {});
  ASSERT_THAT(picture, IsOk());
  ASSERT_EQ(picture->cameras.size(), 4u);
  EXPECT_EQ(picture->cameras[0], 4) << "in the middle";
  EXPECT_EQ(picture->cameras[1], 1) << "above it";
  EXPECT_EQ(picture->cameras[3], 2) << "farthest: above to the right";
}

}  // namespace
}  // namespace floatstage::render
