// A light field from its folder to its scores.
#include "pipeline/light_field.h"

#include "core/mesh_io.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/evaluate/evaluate.h"
#include "pipeline/film.h"
#include "pipeline/import/import.h"
#include "pipeline/scene_loader.h"
#include "tests/render/walls.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kWall = 0.95;  // metres before the cameras

// Five by five pictures of a wall, named after where they were taken.
class LightFieldTake : public testing::Test {
 protected:
  void SetUp() override {
    stage_ = render::photographed(camera_wall(5, 5, 0.05),
                                  render::wall_at(static_cast<float>(kWall) - 1, 0.8F, 0.6F), {}, false);
    fs::create_directories(folder_ / "in");
    for (std::size_t i = 0; i < stage_.rig.cameras.size(); ++i) {
      const Eigen::Vector3d at = stage_.rig.cameras[i].cam_from_world.center();
      const fs::path file =
          folder_ / "in" /
          text("wall_", i / 5, "_", i % 5, "_", -1000 * at.z(), "_", 1000 * at.x(), "_54_36.png");
      ASSERT_THAT(save_png(*to_rgb(stage_.scene.images.frames[i]), file), IsOk());
    }
    options_.calibration = {"lightfield", folder_ / "in"};
    options_.out = folder_ / "take";
  }
  std::unique_ptr<capture::TakeReader> take() const { return *capture::TakeReader::open(folder_ / "take"); }

  TempFolder folder_;
  render::Stage stage_;
  ImportOptions options_;
};

TEST_F(LightFieldTake, GetsItsPlaneWhereThePicturesAgree) {
  const Result<ImportReport> report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->serials.size(), 25u);
  ASSERT_FALSE(report->notes.empty());
  EXPECT_THAT(report->notes.back(), testing::HasSubstr("where neighbouring pictures agree best"));
  const Result<Mesh> plane = load_ply(take()->layout().mesh(0));
  ASSERT_THAT(plane, IsOk());
  EXPECT_NEAR(bounding_box(*plane).center().y(), kWall, 0.02);
}

TEST_F(LightFieldTake, StandsWhereOneSays) {
  options_.plane = 1.5;
  ASSERT_THAT(import_take(options_), IsOk());
  EXPECT_NEAR(bounding_box(*load_ply(take()->layout().mesh(0))).center().y(), 1.5, 1e-6);
  options_.out = folder_ / "behind";
  options_.plane = -1;
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::InvalidArgument, "not before camera"));
  EXPECT_FALSE(fs::exists(folder_ / "behind")) << "whole or not at all";
}

TEST_F(LightFieldTake, NeedsAGridWhereNobodySaysWhereThePlaneIs) {
  fs::remove(*fs::directory_iterator(folder_ / "in"));
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::InvalidArgument, "1 places have no camera"));
  EXPECT_FALSE(fs::exists(folder_ / "take"));
}

TEST_F(LightFieldTake, IsScoredInTheMiddleBetweenItsInputsAndDrawnAsFilms) {
  ASSERT_THAT(import_take(options_), IsOk());
  const auto reader = take();
  EvaluateOptions options;
  options.inputs = {"every:2"};
  options.methods = {"light-field", "linear"};
  options.renderer.back_end = render::BackEnd::Cpu;
  options.renderer.cameras = 4;
  int views = 0;
  const Result<void> done = evaluate_take(*reader, options, [&](const HeldOutView& view) -> Result<void> {
    ++views;
    EXPECT_FALSE(view.has_matte);
    EXPECT_EQ(*view.mask.at(10, 60), 0) << "a twelfth along the sides does not count";
    EXPECT_EQ(*view.mask.at(20, 60), 255);
    EXPECT_GT(view.scores.at("light-field").psnr, 28) << view.serial;
    EXPECT_TRUE(std::isnan(view.scores.at("linear").psnr_edge));
    return {};
  });
  ASSERT_THAT(done, IsOk());
  EXPECT_EQ(views, 4);
  SceneLoader loader(*reader, true);
  const Result<SceneFrame> scene = loader.load(0);
  ASSERT_THAT(scene, IsOk()) << "films draw it without mattes";
  EXPECT_GT(scene->mesh.triangle_count(), 100u);
}

}  // namespace
}  // namespace floatstage::pipeline
