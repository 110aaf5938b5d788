// `export easyvolcap` is read by OpenCV, whose storage EasyVolcap's cameras are, and by our own import.
#include "pipeline/export/export_easyvolcap.h"

#include <gmock/gmock.h>
#include <opencv2/core/persistence.hpp>

#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "tests/pipeline/export/processed_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

TEST(ExportEasyVolcap, HasPicturesMasksHullsAndCamerasOfEachInstant) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.cameras = 4, .lens_k1 = -0.1}), out = folder / "sequence";
  const Result<ExportEasyVolcapReport> report =
      export_easyvolcap({.take = take, .out = out, .frames = {1, 0}});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->frames, 2);
  EXPECT_EQ(report->pictures, 8);
  EXPECT_EQ(report->masks, 8);
  const Rig rig = load_rig(take / "rig.json").value();
  for (const RigCamera& camera : rig.cameras)
    for (const char* name : {"000000.png", "000001.png"}) {
      const Result<Image> picture = load_png(out / "images" / camera.serial / name),
                          mask = load_png(out / "masks" / camera.serial / name);
      ASSERT_THAT(picture, IsOk());
      ASSERT_THAT(mask, IsOk());
      EXPECT_EQ(picture->width, camera.model.width);
      EXPECT_EQ(mask->channels, 1);
    }
  // The order of --frames: instant 0 of the sequence is frame 1 of the take.
  const Result<Mesh> hull = load_ply(out / "vhulls/000000.ply"), own = load_ply(take / "meshes/000001.ply");
  ASSERT_THAT(hull, IsOk());
  ASSERT_THAT(own, IsOk());
  EXPECT_EQ(hull->positions, own->positions);
  EXPECT_EQ(hull->triangles, own->triangles);
}

TEST(ExportEasyVolcap, CamerasReprojectAsTheTakesWithoutTheirLens) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1, .lens_k1 = -0.1}), out = folder / "sequence";
  ASSERT_THAT(export_easyvolcap({.take = take, .out = out, .frames = {0}}), IsOk());
  const Rig rig = load_rig(take / "rig.json").value();
  const Result<calib::ForeignRig> back = calib::read_rig({.format = "opencv", .path = out});
  ASSERT_THAT(back, IsOk());
  ASSERT_EQ(back->rig.cameras.size(), rig.cameras.size());
  const cv::FileStorage intri((out / "intri.yml").string(), cv::FileStorage::READ),
      extri((out / "extri.yml").string(), cv::FileStorage::READ);
  const Eigen::Vector3d point(0.2, -0.1, 1.4);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    CameraModel straight = rig.cameras[c].model;
    straight.lens = {};
    const Eigen::Vector2d pixel = *project(straight, rig.cameras[c].cam_from_world * point);
    const RigCamera& read = back->rig.cameras[c];
    EXPECT_EQ(read.model.lens, Lens{}) << "pictures are straight";
    EXPECT_LT((*project(read.model, read.cam_from_world * point) - pixel).norm(), 1e-9);
    // As EasyVolcap does: OpenCV's matrices, pixels counted from the first one's centre.
    const std::string& serial = rig.cameras[c].serial;
    cv::Mat k, r, t;
    intri["K_" + serial] >> k;
    extri["Rot_" + serial] >> r;
    extri["T_" + serial] >> t;
    const cv::Mat p = k * (r * cv::Mat(3, 1, CV_64F, const_cast<double*>(point.data())) + t);
    const Eigen::Vector2d seen(p.at<double>(0) / p.at<double>(2), p.at<double>(1) / p.at<double>(2));
    EXPECT_LT((seen - (pixel - Eigen::Vector2d(0.5, 0.5))).norm(), 1e-6);
  }
}

TEST(ExportEasyVolcap, LeavesOutFramesThatACameraMissed) {
  TempFolder folder;
  const fs::path take = processed_take(folder), out = folder / "sequence";
  std::string rows = read_file(take / "cam02.frames.csv").value();
  const std::size_t last = rows.find_last_of('\n', rows.size() - 2);
  ASSERT_THAT(write_file(take / "cam02.frames.csv", rows.substr(0, last + 1)), IsOk());
  const Result<ExportEasyVolcapReport> report =
      export_easyvolcap({.take = take, .out = out, .frames = {0, 1}});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->frames, 1);
  EXPECT_THAT(report->left_out, ElementsAre(1));
  EXPECT_THAT(export_easyvolcap({.take = take, .out = folder / "none", .frames = {1}}),
              FailsWith(ErrorCode::NotFound, "each camera"));
  EXPECT_THAT(folder.names(), ElementsAre("sequence", "take"));
}

TEST(ExportEasyVolcap, LeavesNothingBehindWhereItFails) {
  TempFolder folder;
  const fs::path take = processed_take(folder, {.frames = 1}), out = folder / "sequence";
  EXPECT_THAT(export_easyvolcap({.take = take, .out = out, .frames = {0}, .cameras = {"cam77"}}),
              FailsWith(ErrorCode::InvalidArgument, "no camera 'cam77'"));
  fs::remove(take / "meshes/000000.ply");
  EXPECT_THAT(export_easyvolcap({.take = take, .out = out, .frames = {0}}),
              FailsWith(ErrorCode::NotFound, "run `floatstage process"));
  EXPECT_THAT(folder.names(), ElementsAre("take"));
}

}  // namespace
}  // namespace floatstage::pipeline
