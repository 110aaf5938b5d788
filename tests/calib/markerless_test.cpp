#include "calib/markerless.h"

#include <atomic>
#include <filesystem>

#include <gtest/gtest.h>

#include "calib/child_program.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

// A stand-in for COLMAP that does as its script says.
std::string program(const TempFolder& folder, const std::string& script) {
  const fs::path file = folder.write("fake-colmap", "#!/bin/sh\n" + script + "\n");
  fs::permissions(file, fs::perms::owner_all);
  return file.string();
}

std::vector<MarkerlessPicture> two_pictures(const TempFolder& folder) {
  const CameraModel model = test::simple_camera(64, 48, 50);
  const Image black(64, 48, 1);
  return {{"a", folder.write("a.png", "a"), model, black}, {"b", folder.write("b.png", "b"), model, black}};
}

TEST(Markerless, SaysThatColmapIsNotInstalled) {
  const TempFolder folder;
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work", {.program = "no-such-colmap"}),
              FailsWith(ErrorCode::NotFound, "install the package 'colmap'"));
}

TEST(Markerless, PassesOnTheStepItsCodeAndTheEndOfItsLog) {
  const TempFolder folder;
  const auto failing =
      program(folder, "echo step $1; if [ $1 = mapper ]; then echo no good initial pair; exit 1; fi");
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work", {.program = failing}),
              FailsWith(ErrorCode::BadData, "COLMAP's mapper ended with code 1: too little is seen"));
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work2", {.program = failing}),
              FailsWith(ErrorCode::BadData, "no good initial pair"));
  EXPECT_EQ(end_of_log(fs::path(folder / "work" / "colmap.log"), 9),
            "step feature_importer;step matches_importer;step mapper;no good initial pair");
}

TEST(Markerless, SurvivesACrash) {
  const TempFolder folder;
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work",
                                   {.program = program(folder, "kill -ABRT $$")}),
              FailsWith(ErrorCode::BadData, "feature_importer was ended by signal 6"));
}

TEST(Markerless, EndsAProgramThatHangs) {
  const TempFolder folder;
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work",
                                   {.program = program(folder, "sleep 600 & wait"), .timeout = 0.2}),
              FailsWith(ErrorCode::Timeout, "took longer than 0.2 s"));
}

TEST(Markerless, EndsItsProgramWhenItIsInterrupted) {
  const TempFolder folder;
  std::atomic<int> asked{0};  // on several threads
  MarkerlessOptions options{.program = program(folder, "sleep 600 & wait")};
  options.cancelled = [&] { return ++asked > 6; };  // the program runs by then
  EXPECT_THAT(calibrate_markerless(two_pictures(folder), folder / "work", options),
              FailsWith(ErrorCode::Cancelled, "was interrupted"));
}

TEST(Markerless, RefusesAnEmptyModelFolder) {
  const TempFolder folder;
  EXPECT_THAT(
      calibrate_markerless(two_pictures(folder), folder / "work", {.program = program(folder, "exit 0")}),
      FailsWith(ErrorCode::BadData, "COLMAP found no model"));
}

TEST(Markerless, RunsWithoutADisplayOrAGraphicsCard) {
  const TempFolder folder;
  const auto quiet = program(folder, "echo $@");
  EXPECT_FALSE(calibrate_markerless(two_pictures(folder), folder / "work", {.program = quiet}));
  const std::string log = end_of_log(fs::path(folder / "work" / "colmap.log"), 99);
  EXPECT_THAT(log, testing::HasSubstr("--SiftMatching.use_gpu 0"));
}

TEST(Markerless, ChecksWhatItIsGivenBeforeItTouchesAnything) {
  const TempFolder folder;
  auto pictures = two_pictures(folder);
  EXPECT_THAT(calibrate_markerless({pictures[0]}, folder / "w", {}),
              FailsWith(ErrorCode::InvalidArgument, "two cameras"));
  EXPECT_THAT(calibrate_markerless(pictures, folder.path(), {}),
              FailsWith(ErrorCode::AlreadyExists, "new folder"));
  pictures[1].file = folder / "none.png";
  EXPECT_THAT(calibrate_markerless(pictures, folder / "w", {}), FailsWith(ErrorCode::NotFound, "none.png"));
  pictures[1].pixels = Image(64, 47, 1);
  EXPECT_THAT(calibrate_markerless(pictures, folder / "w", {}),
              FailsWith(ErrorCode::InvalidArgument, "has 64x47 pixels"));
  EXPECT_THAT(triangulate_markerless(pictures, {}),
              FailsWith(ErrorCode::InvalidArgument, "has 64x47 pixels"));
  pictures[1].serial = "a";
  EXPECT_THAT(calibrate_markerless(pictures, folder / "w", {}),
              FailsWith(ErrorCode::InvalidArgument, "twice"));
  EXPECT_FALSE(fs::exists(folder / "w"));
}

TEST(ScaleTo, PutsTwoCamerasAtTheirDistance) {
  Rig rig;
  for (const double x : {0.0, 1.0, 4.0})
    rig.cameras.push_back({.serial = text("c", x),
                           .model = test::simple_camera(64, 48, 50),
                           .cam_from_world = look_at({x, 0, 1}, {x, 2, 1}, {0, 0, 1}),
                           .color = {}});
  const Result<Rig> scaled = scale_to(rig, "c0", "c4", 2);
  ASSERT_THAT(scaled, IsOk());
  EXPECT_NEAR(
      (scaled->cameras[0].cam_from_world.center() - scaled->cameras[2].cam_from_world.center()).norm(), 2,
      1e-12);
  EXPECT_NEAR(
      (scaled->cameras[0].cam_from_world.center() - scaled->cameras[1].cam_from_world.center()).norm(), 0.5,
      1e-12);
  EXPECT_THAT(scale_to(rig, "c0", "x", 2), FailsWith(ErrorCode::NotFound, "'x'"));
  EXPECT_THAT(scale_to(rig, "c0", "c0", 2), FailsWith(ErrorCode::InvalidArgument, "cannot be 2 m apart"));
  EXPECT_THAT(scale_to(rig, "c0", "c1", -1), FailsWith(ErrorCode::InvalidArgument, "-1 m"));
}

}  // namespace
}  // namespace floatstage::calib
