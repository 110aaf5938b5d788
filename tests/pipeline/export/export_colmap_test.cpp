// `export colmap` is read by COLMAP 3.8 itself.
#include "pipeline/export/export_colmap.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "tests/pipeline/export/processed_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// What the log says after `label`, as a number; NaN when it does not.
double said(const std::string& log, const std::string& label) {
  const std::size_t at = log.find(label);
  return at == std::string::npos ? std::nan("") : std::atof(log.c_str() + at + label.size());
}

TEST(ExportColmap, IsOpenedByColmapWhichTriangulatesOnIt) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.cameras = 16, .frames = 1, .width = 320, .height = 240}),
                 out = folder / "project", log = folder / "log";
  const Result<ExportColmapReport> report = export_colmap({.take = take, .out = out, .frames = {0}});
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(run_other(text("colmap model_analyzer --path ", (out / "sparse/0").string()), log), 0);
  std::string words = read_file(log).value();
  EXPECT_EQ(said(words, "Registered images: "), 16) << words;
  EXPECT_EQ(said(words, "Points: "), static_cast<double>(report->points)) << words;
  for (const char* extension : {".bin", ".txt"}) {  // either kind of file alone is a whole model
    const fs::path alone = folder / text("only", extension);
    fs::create_directory(alone);
    for (const char* name : {"cameras", "images", "points3D"})
      fs::copy(out / "sparse/0" / text(name, extension), alone);
    EXPECT_EQ(run_other(text("colmap model_analyzer --path ", alone.string()), log), 0) << extension;
  }

  const std::string base = text(" --database_path ", (folder / "db").string());
  const std::string pictures = text(" --image_path ", (out / "images").string());
  fs::create_directory(folder / "tri");
  ASSERT_EQ(run_other(text("colmap feature_extractor", base, pictures, " --ImageReader.mask_path ",
                           (out / "masks").string(),
                           " --ImageReader.single_camera_per_image 1 --SiftExtraction.use_gpu 0"),
                      log),
            0);
  ASSERT_EQ(run_other(text("colmap exhaustive_matcher", base, " --SiftMatching.use_gpu 0"), log), 0);
  const std::string to_text =
      text("colmap point_triangulator", base, pictures, " --clear_points 1 --input_path ",
           (out / "sparse/0").string(), " --output_path ", (folder / "tri").string());
  ASSERT_EQ(run_other(to_text, log), 0) << read_file(log).value();
  ASSERT_EQ(run_other(text("colmap model_analyzer --path ", (folder / "tri").string()), folder / "tri.log"),
            0);
  words = read_file(folder / "tri.log").value();
  EXPECT_GE(said(words, "Points: "), 50) << words;
  EXPECT_LE(said(words, "Mean reprojection error: "), 1) << words;
}

TEST(ExportColmap, SaysTheSameCamerasThreeTimes) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1, .lens_k1 = -0.1}), out = folder / "project";
  ASSERT_THAT(export_colmap({.take = take, .out = out, .frames = {0}}), IsOk());
  const Rig rig = load_rig(take / "rig.json").value();
  const Result<calib::ForeignRig> back = calib::read_rig({.format = "colmap", .path = out});
  ASSERT_THAT(back, IsOk());
  const nlohmann::json transforms = nlohmann::json::parse(read_file(out / "transforms.json").value());
  ASSERT_EQ(back->rig.cameras.size(), rig.cameras.size());
  const Eigen::Vector3d point(0.2, -0.1, 1.4);
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    CameraModel expected = rig.cameras[i].model;
    expected.lens = {};
    const Eigen::Vector3d p = rig.cameras[i].cam_from_world * point;
    const Eigen::Vector2d pixel = *project(expected, p);
    const RigCamera& read = back->rig.cameras[i];
    EXPECT_EQ(read.model.lens, Lens{}) << "pictures are straight";
    EXPECT_LT((*project(read.model, read.cam_from_world * point) - pixel).norm(), 1e-9);
    // OpenGL's axes: x right, y up, z backward.
    const nlohmann::json& frame = transforms["frames"][i];
    Eigen::Matrix4d world_from_camera;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) world_from_camera(r, c) = frame["transform_matrix"][r][c];
    const Eigen::Vector3d q = (world_from_camera.inverse() * point.homogeneous()).hnormalized();
    const Eigen::Vector2d gl(frame["fl_x"].get<double>() * q.x() / -q.z() + frame["cx"].get<double>(),
                             -frame["fl_y"].get<double>() * q.y() / -q.z() + frame["cy"].get<double>());
    EXPECT_LT((gl - pixel).norm(), 1e-9);
    EXPECT_TRUE(fs::exists(out / frame["file_path"].get<std::string>()));
    EXPECT_TRUE(fs::exists(out / frame["mask_path"].get<std::string>()));
  }
  const Result<Mesh> points = load_ply(out / transforms["ply_file_path"].get<std::string>());
  ASSERT_THAT(points, IsOk());
  EXPECT_GT(points->positions.size(), 500u);
  EXPECT_TRUE(points->triangles.empty());
}

TEST(ExportColmap, PutsMattesIntoTheAlphaChannelOnRequest) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 2}), out = folder / "project";
  const Result<ExportColmapReport> report = export_colmap(
      {.take = take, .out = out, .frames = {0, 1}, .cameras = {"cam01", "cam03"}, .alpha = true});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->pictures, 4);
  for (const char* frame : {"000000", "000001"}) {
    const Result<Image> picture = load_png(out / frame / "images/cam01.png"),
                        mask = load_png(out / frame / "masks/cam01.png.png");
    ASSERT_THAT(picture, IsOk());
    ASSERT_THAT(mask, IsOk());
    ASSERT_EQ(picture->channels, 4);
    int inside = 0;
    for (std::size_t p = 0; p < mask->pixels.size(); ++p) {
      ASSERT_EQ(picture->pixels[4 * p + 3], mask->pixels[p]);
      inside += mask->pixels[p] > 128 ? 1 : 0;
    }
    EXPECT_GT(inside, 100);
  }
}

TEST(ExportColmap, LeavesNothingBehindWhereItFails) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1}), out = folder / "project";
  EXPECT_THAT(export_colmap({.take = take, .out = out, .frames = {0}, .cameras = {"cam77"}}),
              FailsWith(ErrorCode::InvalidArgument, "no camera 'cam77'"));
  fs::remove(take / "meshes/000000.ply");
  EXPECT_THAT(export_colmap({.take = take, .out = out, .frames = {0}}),
              FailsWith(ErrorCode::NotFound, "run `floatstage process"));
  EXPECT_THAT(folder.names(), testing::ElementsAre("take"));
  fs::create_directory(out);
  folder.write("project/notes", "yesterday's");
  EXPECT_THAT(export_colmap({.take = take, .out = out, .frames = {0}}),
              FailsWith(ErrorCode::AlreadyExists, "project"));
  EXPECT_EQ(read_file(out / "notes").value(), "yesterday's");
}

}  // namespace
}  // namespace floatstage::pipeline
