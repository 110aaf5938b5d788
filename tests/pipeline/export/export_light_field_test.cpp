#include "pipeline/export/export_light_field.h"

#include <gmock/gmock.h>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/subject.h"
#include "render/camera_grid.h"
#include "tests/pipeline/export/processed_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class AnExportedLightField : public testing::Test {
 protected:
  void SetUp() override {
    options_.take = processed_take(folder_, {.frames = 1});
    options_.out = folder_ / "field";
    options_.rows = 2, options_.columns = 3;
    options_.middle.eye = {0.3, -3, 1.4}, options_.middle.target = {0, 0, 1};
    options_.film.width = 120, options_.film.height = 90;
    options_.film.frames = {0};
    options_.film.methods = {"linear"};
    options_.film.renderer.back_end = render::BackEnd::Cpu;
  }
  TempFolder folder_;
  ExportLightFieldOptions options_;
};

TEST_F(AnExportedLightField, IsReadByItsNamesAndByColmap) {
  const Result<ExportLightFieldReport> report = export_light_field(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->pictures, 6);
  const Result<calib::ForeignRig> named = calib::read_rig({"lightfield", options_.out, 1});
  ASSERT_THAT(named, IsOk());
  const Result<render::CameraGrid> grid = render::camera_grid(named->rig.cameras);
  ASSERT_THAT(grid, IsOk());
  EXPECT_EQ(grid->rows, 2);
  EXPECT_EQ(grid->columns, 3);
  const Result<calib::ForeignRig> model = calib::read_rig({"colmap", options_.out / "sparse/0", 1});
  ASSERT_THAT(model, IsOk());
  ASSERT_EQ(model->rig.cameras.size(), 6u);
  // The same cameras but for where their world is: a point before the first stands at the same pixels.
  const Rigid3 world = model->rig.cameras[0].cam_from_world.inverse(),
               field = named->rig.cameras[0].cam_from_world.inverse();
  for (std::size_t i = 0; i < 6; ++i) {
    const RigCamera &a = model->rig.cameras[i], &b = named->rig.cameras[i];
    EXPECT_EQ(model->image_names[i], named->image_names[i]);
    const Eigen::Vector3d point(0.3, -0.2, 3);
    const auto p = project(a.model, a.cam_from_world * (world * point)),
               q = project(b.model, b.cam_from_world * (field * point));
    ASSERT_TRUE(p && q);
    EXPECT_LT((*p - *q).norm(), 1e-3) << "px, camera " << i;
    EXPECT_THAT(load_png(named->pictures / named->image_names[i]), IsOk());
  }
  const fs::path log = folder_ / "colmap.log";
  EXPECT_EQ(run_other(text("colmap model_analyzer --path ", (options_.out / "sparse/0").string()), log), 0)
      << *read_file(log);
  EXPECT_TRUE(fs::exists(options_.out / "transforms.json"));
  EXPECT_THAT(calib::read_rig({"transforms", options_.out, 1}), IsOk());
}

TEST_F(AnExportedLightField, ShowsWhatAFilmShowsThere) {
  ASSERT_THAT(export_light_field(options_), IsOk());
  const Result<calib::ForeignRig> named = calib::read_rig({"lightfield", options_.out, 1});
  ASSERT_THAT(named, IsOk());
  const auto take = std::move(*capture::TakeReader::open(options_.take));
  // The middle of three columns, above: half a step over the middle.
  PathKey key = options_.middle;
  const Eigen::Vector3d down =
      look_at(key.eye, key.target, key.up).rotation.toRotationMatrix().row(1) * (-0.5 * options_.baseline);
  key.eye += down, key.target += down;
  FilmOptions film = options_.film;
  film.seconds = 1 / film.frame_rate;
  Image wanted;
  ASSERT_THAT(render_film(*take, CameraPath{{key}}, film,
                          [&](const FilmPicture& picture) -> Result<void> {
                            wanted = over(picture.renders.front(), film.renderer.background);
                            return {};
                          }),
              IsOk());
  const Result<Image> drawn = load_png(named->pictures / named->image_names[1]);
  ASSERT_THAT(drawn, IsOk());
  ASSERT_EQ(drawn->pixels.size(), wanted.pixels.size());
  std::size_t apart = 0, lit = 0;
  for (std::size_t i = 0; i < wanted.pixels.size(); ++i) {
    apart += std::abs(int(wanted.pixels[i]) - int(drawn->pixels[i])) > 8 ? 1 : 0;
    lit += wanted.pixels[i] > 32 ? 1 : 0;
  }
  EXPECT_GT(lit, wanted.pixels.size() / 100) << "somebody is there";
  EXPECT_LT(apart, wanted.pixels.size() / 500);
}

TEST_F(AnExportedLightField, IsRefusedAsARowAndLeavesNothing) {
  options_.rows = 1;
  EXPECT_THAT(export_light_field(options_), FailsWith(ErrorCode::InvalidArgument, "rows and columns"));
  options_.rows = 2;
  options_.film.frames = {7};
  EXPECT_THAT(export_light_field(options_), FailsWith(ErrorCode::InvalidArgument, "frame 7"));
  EXPECT_FALSE(fs::exists(options_.out));
}

}  // namespace
}  // namespace floatstage::pipeline
