#include "pipeline/scene_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "pipeline/process/process.h"
#include "pipeline/subject.h"
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
  Result<SceneFrame> load() {
    const auto take = open();
    return SceneLoader(*take, false).load(0);
  }
  TempFolder folder_;
  fs::path path_;
};

TEST_F(ProcessedTake, LoadsPhotographsMattesAndMeshOfOneInstant) {
  const auto take = open();
  const Result<SceneFrame> scene = SceneLoader(*take, false).load(0);
  ASSERT_THAT(scene, IsOk());
  EXPECT_EQ(scene->images.frames.size(), 6u);
  EXPECT_EQ(scene->mattes.size(), 6u);
  EXPECT_FALSE(scene->mesh.empty());
  for (std::size_t i = 0; i < 6; ++i) EXPECT_FALSE(scene->mattes[i].empty()) << i;
}

TEST_F(ProcessedTake, TakesTheClothsCastOffThePhotographsOnRequest) {
  const auto take = open();
  auto excess_green = [&](bool suppress) {
    const Image rgb = *to_rgb(SceneLoader(*take, suppress).load(0)->images.frames[0]);
    long excess = 0;
    for (std::size_t i = 0; i < rgb.pixels.size(); i += 3)
      excess += std::max(0, rgb.pixels[i + 1] - std::max(rgb.pixels[i], rgb.pixels[i + 2]));
    return excess;
  };
  EXPECT_LT(excess_green(true), excess_green(false) / 2);
}

TEST_F(ProcessedTake, HasItsSubjectInABoxAroundThePerformer) {
  const Result<Subject> subject = find_subject(*open());
  ASSERT_THAT(subject, IsOk());
  EXPECT_GT(subject->box.sizes().z(), 1.0) << "a person stands";
  EXPECT_LT(subject->box.sizes().maxCoeff(), 3.0);
  EXPECT_LT(subject->box.center().head<2>().norm(), 0.6) << "in the middle of the stage";
}

TEST_F(ProcessedTake, SaysWhichStageIsMissing) {
  fs::remove_all(TakeLayout(path_).meshes());
  EXPECT_THAT(load(), FailsWith(ErrorCode::NotFound, "floatstage process"));
  EXPECT_THAT(find_subject(*open()), FailsWith(ErrorCode::NotFound, "floatstage process"));
}

TEST_F(ProcessedTake, ShowsNoPictureThatIsOlderThanItsSilhouettes) {
  ASSERT_THAT(load(), IsOk());
  const fs::path matte = TakeLayout(path_).matte("cam03", 0);
  Result<Image> painted = load_png(matte);
  ASSERT_THAT(painted, IsOk());
  painted->pixels[0] ^= 255;
  ASSERT_THAT(save_png(*painted, matte), IsOk());
  EXPECT_THAT(load(), FailsWith(ErrorCode::NotFound, "older than the matte of camera 'cam03'"));
  ASSERT_THAT(process_take({.take = path_}), IsOk());
  EXPECT_THAT(load(), IsOk());
}

TEST_F(ProcessedTake, SeesInALoaderThatIsKeptWhatAnotherProgramMakesAgain) {
  const auto take = open();
  SceneLoader loader(*take, true);
  const Result<SceneFrame> before = loader.load(0);
  ASSERT_THAT(before, IsOk());
  const fs::path matte = TakeLayout(path_).matte("cam03", 0);
  Result<Image> painted = load_png(matte);
  ASSERT_THAT(painted, IsOk());
  std::fill_n(painted->pixels.begin(), painted->pixels.size() / 2, std::uint8_t{0});
  ASSERT_THAT(save_png(*painted, matte), IsOk());
  EXPECT_THAT(loader.load(0), FailsWith(ErrorCode::NotFound, "older than the matte of camera 'cam03'"));
  ASSERT_THAT(process_take({.take = path_}), IsOk());
  const Result<SceneFrame> after = loader.load(0);
  ASSERT_THAT(after, IsOk());
  EXPECT_NE(after->mesh.positions.size(), before->mesh.positions.size());

  // Keyed another way, the cast that is taken off is another.
  const fs::path made = TakeLayout(path_).made_mattes();
  std::string record = *read_file(made);
  for (std::size_t at; (at = record.find("\"chroma:")) != std::string::npos;)
    record.replace(at, 8, "\"plate:");
  ASSERT_THAT(write_file(made, record), IsOk());
  const Result<SceneFrame> untouched = loader.load(0);
  ASSERT_THAT(untouched, IsOk());
  EXPECT_NE(to_rgb(untouched->images.frames[0])->pixels, to_rgb(after->images.frames[0])->pixels);
}

TEST_F(ProcessedTake, LoadsTheSameOnManyThreadsAtOnce) {
  const auto take = open();
  SceneLoader loader(*take, true);
  std::vector<std::vector<std::uint8_t>> seen(8);
  parallel_for(seen.size(), 4, [&](std::size_t i) {
    const Result<SceneFrame> scene = loader.load(0);
    if (scene) seen[i] = to_rgb(scene->images.frames[1])->pixels;
  });
  EXPECT_FALSE(seen[0].empty());
  for (const std::vector<std::uint8_t>& pixels : seen) EXPECT_EQ(pixels, seen[0]);
}

TEST_F(ProcessedTake, RefusesAMatteOfAnotherSizeByName) {
  const fs::path matte = TakeLayout(path_).matte("cam03", 0);
  ASSERT_THAT(save_png(Image(20, 20, 1), matte), IsOk());
  EXPECT_THAT(load(), FailsWith(ErrorCode::BadData, "cam03"));
  ASSERT_THAT(write_file(matte, "not a picture"), IsOk());
  EXPECT_THAT(load(), FailsWith(ErrorCode::BadData, matte.string()));
}

}  // namespace
}  // namespace floatstage::pipeline
