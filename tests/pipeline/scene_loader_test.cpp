#include "pipeline/scene_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/process/process.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class ProcessedTake : public testing::Test {
 protected:
  void SetUp() override {
    path_ = small_take(folder_, 1);
    ProcessOptions options{.take = path_, .matte = "chroma", .hull = recon::HullOptions{}};
    options.hull->resolution = 48;
    ASSERT_THAT(process_take(options), IsOk());
  }
  std::unique_ptr<capture::TakeReader> open() {
    auto take = capture::TakeReader::open(path_);
    EXPECT_THAT(take, IsOk());
    return std::move(*take);
  }
  TempFolder folder_;
  fs::path path_;
};

TEST_F(ProcessedTake, LoadsPhotographsMattesAndMeshOfOneInstant) {
  const auto take = open();
  const Result<SceneFrame> scene = load_scene(*take, 0, false);
  ASSERT_THAT(scene, IsOk());
  EXPECT_EQ(scene->images.frames.size(), 6u);
  EXPECT_EQ(scene->mattes.size(), 6u);
  EXPECT_FALSE(scene->mesh.empty());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FALSE(scene->mattes[i].empty()) << i;
}

TEST_F(ProcessedTake, TakesTheClothsCastOffThePhotographsOnRequest) {
  const auto take = open();
  auto excess_green = [&](bool suppress) {
    const Image rgb = *to_rgb(load_scene(*take, 0, suppress)->images.frames[0]);
    long excess = 0;
    for (std::size_t i = 0; i < rgb.pixels.size(); i += 3)
      excess += std::max(0, rgb.pixels[i + 1] - std::max(rgb.pixels[i], rgb.pixels[i + 2]));
    return excess;
  };
  EXPECT_LT(excess_green(true), excess_green(false) / 2);
}

TEST_F(ProcessedTake, HasItsSubjectInABoxAroundThePerformer) {
  const Result<Eigen::AlignedBox3d> box = subject_box(*open());
  ASSERT_THAT(box, IsOk());
  EXPECT_GT(box->sizes().z(), 1.0) << "a person stands";
  EXPECT_LT(box->sizes().maxCoeff(), 3.0);
  EXPECT_LT(box->center().head<2>().norm(), 0.6) << "in the middle of the stage";
}

TEST_F(ProcessedTake, SaysWhichStageIsMissing) {
  fs::remove_all(TakeLayout(path_).meshes());
  EXPECT_THAT(load_scene(*open(), 0, false), FailsWith(ErrorCode::NotFound, "floatstage process"));
  EXPECT_THAT(subject_box(*open()), FailsWith(ErrorCode::NotFound, "floatstage process"));
}

TEST_F(ProcessedTake, ShowsNoPictureThatIsOlderThanItsSilhouettes) {
  ASSERT_THAT(load_scene(*open(), 0, false), IsOk());
  const fs::path matte = TakeLayout(path_).matte("cam03", 0);
  Result<Image> painted = load_png(matte);
  ASSERT_THAT(painted, IsOk());
  painted->pixels[0] ^= 255;
  ASSERT_THAT(save_png(*painted, matte), IsOk());
  EXPECT_THAT(load_scene(*open(), 0, false),
              FailsWith(ErrorCode::NotFound, "older than the matte of camera 'cam03'"));
  ASSERT_THAT(process_take({.take = path_}), IsOk());
  EXPECT_THAT(load_scene(*open(), 0, false), IsOk());
}

TEST_F(ProcessedTake, RefusesAMatteOfAnotherSizeByName) {
  const fs::path matte = TakeLayout(path_).matte("cam03", 0);
  ASSERT_THAT(save_png(Image(20, 20, 1), matte), IsOk());
  EXPECT_THAT(load_scene(*open(), 0, false), FailsWith(ErrorCode::BadData, "cam03"));
  ASSERT_THAT(write_file(matte, "not a picture"), IsOk());
  EXPECT_THAT(load_scene(*open(), 0, false), FailsWith(ErrorCode::BadData, matte.string()));
}

}  // namespace
}  // namespace floatstage::pipeline
