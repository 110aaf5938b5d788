#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/rig_formats.h"
#include "capture/derivation.h"
#include "capture/sound/time_code.h"
#include "capture/take_check.h"
#include "core/file.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/derive/join.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/occluders.h"
#include "pipeline/process/process.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class ANewTake : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder();
    small_take(*shared_, 4);
  }
  static void TearDownTestSuite() { delete shared_; }

  static std::unique_ptr<capture::TakeReader> open(const fs::path& folder) {
    auto take = capture::TakeReader::open(folder);
    EXPECT_THAT(take, IsOk());
    return std::move(*take);
  }
  static fs::path recorded() { return *shared_ / "take"; }
  static std::string picture(capture::TakeReader& take, int camera, int frame) {
    const Result<Image> rgb = to_rgb(*take.frame(camera, frame));
    return rgb ? std::string(rgb->pixels.begin(), rgb->pixels.end()) : std::string();
  }
  static bool is_intact(const fs::path& take) {
    const auto check = capture::check_take(take, [](std::uint64_t) { return true; });
    EXPECT_THAT(check, IsOk());
    EXPECT_THAT(check->problems, IsEmpty());
    return check->sealed;
  }
  std::size_t left_over() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
  }

  static TempFolder* shared_;
  TempFolder folder_;
};
TempFolder* ANewTake::shared_ = nullptr;

TEST_F(ANewTake, WithAnotherRigSharesItsMediaAndKeepsItsSeal) {
  const auto take = open(recorded());
  Rig rig = take->rig();
  std::swap(rig.cameras[0], rig.cameras[1]);  // the take's order counts, not the calibration's
  for (RigCamera& c : rig.cameras) c.model.fx *= 1.01;
  const Result<Rig> fitted = rig_for(*take, rig, "rig.json");
  ASSERT_THAT(fitted, IsOk());
  const fs::path out = folder_ / "calibrated";
  const Result<DerivedReport> report =
      derive_take(*take, {.rig = *fitted, .how = "set-rig rig.json", .label = ""}, out);
  ASSERT_THAT(report, IsOk());
  EXPECT_GT(report->shared, 0u);
  EXPECT_EQ(report->copied, 0u) << "one file system";
  const auto made = open(out);
  EXPECT_DOUBLE_EQ(made->rig().cameras[0].model.fx, 1.01 * take->rig().cameras[0].model.fx);
  EXPECT_EQ(made->rig().cameras[0].serial, take->rig().cameras[0].serial);
  EXPECT_EQ(picture(*made, 3, 2), picture(*take, 3, 2));
  EXPECT_TRUE(is_intact(out));
  EXPECT_THAT(made->warnings(), IsEmpty());
  fs::remove_all(out);
  EXPECT_TRUE(is_intact(recorded())) << "either may be removed";
}

TEST_F(ANewTake, OfAnotherRigRefusesCamerasThatAreNotThereAndOtherSizes) {
  const auto take = open(recorded());
  Rig fewer = take->rig();
  fewer.cameras.pop_back();
  EXPECT_THAT(rig_for(*take, fewer, "rig.json"),
              FailsWith(ErrorCode::NotFound, take->rig().cameras.back().serial));
  Rig other = take->rig();
  other.cameras[2].model.width = 320;
  EXPECT_THAT(rig_for(*take, other, "rig.json"), FailsWith(ErrorCode::BadData, "320x120"));
}

TEST_F(ANewTake, ThatWasTrimmedShowsItsFramesAndSaysNothingOfTheOthers) {
  const auto take = open(recorded());
  const fs::path out = folder_ / "part";
  ASSERT_THAT(derive_take(*take, {.rig = {}, .first = 1, .end = 3, .how = "trim 1:3", .label = "scene"}, out),
              IsOk());
  const auto made = open(out);
  EXPECT_EQ(made->frame_count(), 2);
  EXPECT_EQ(made->manifest().label, "scene");
  for (int f = 0; f < 2; ++f) EXPECT_EQ(picture(*made, 2, f), picture(*take, 2, f + 1));
  EXPECT_EQ(made->rows(2)[0].info.exposure_start, take->rows(2)[1].info.exposure_start) << "times stay";
  EXPECT_THAT(made->warnings(), IsEmpty());
  EXPECT_TRUE(is_intact(out));
  EXPECT_EQ((*capture::load_derivation(out))->how, "trim 1:3");
}

TEST_F(ANewTake, OfFramesThatAreNotThereIsRefusedAndNothingIsLeft) {
  const auto take = open(recorded());
  for (const auto& [first, end] : {std::pair{2, 9}, {-1, 2}, {3, 3}})
    EXPECT_THAT(
        derive_take(*take, {.rig = {}, .first = first, .end = end, .how = "", .label = ""}, folder_ / "part"),
        FailsWith(ErrorCode::InvalidArgument, "has 4"));
  EXPECT_EQ(left_over(), 0u);
}

TEST_F(ANewTake, NeverReplacesWhatIsThere) {
  const auto take = open(recorded());
  fs::create_directory(folder_ / "mine");
  ASSERT_THAT(write_file(folder_ / "mine" / "notes.txt", "x"), IsOk());
  EXPECT_THAT(derive_take(*take, {.rig = {}, .first = 0, .end = 2, .how = "", .label = ""}, folder_ / "mine"),
              FailsWith(ErrorCode::AlreadyExists, "mine"));
  EXPECT_EQ(*read_file(folder_ / "mine" / "notes.txt"), "x");
  EXPECT_EQ(left_over(), 1u);
}

TEST_F(ANewTake, CarriesMattesAlongAndLeavesHullsOut) {
  const fs::path own = small_take(folder_, 2);
  recon::HullOptions hull;
  hull.method = recon::HullMethod::Octree;
  ASSERT_THAT(process_take({.take = own, .matte = "chroma", .hull = hull}), IsOk());
  const auto take = open(own);
  const auto report =
      derive_take(*take, {.rig = take->rig(), .how = "set-rig", .label = ""}, folder_ / "new");
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->notes, Contains(HasSubstr("floatstage process")));
  EXPECT_EQ(facts_of(*open(folder_ / "new")).mattes, 12);
  EXPECT_EQ(facts_of(*open(folder_ / "new")).meshes, 0);
  const auto part =
      derive_take(*take, {.rig = {}, .first = 1, .end = 2, .how = "trim", .label = ""}, folder_ / "part");
  ASSERT_THAT(part, IsOk());
  EXPECT_EQ(*read_file(TakeLayout(folder_ / "part").matte("cam01", 0)),
            *read_file(take->layout().matte("cam01", 1)));
}

TEST_F(ANewTake, CarriesMasksOfWhatStandsOnTheStageAlong) {
  const fs::path own = small_take(folder_, 2);
  const fs::path mask = occluder_file(TakeLayout(own), "cam02");
  fs::create_directories(mask.parent_path());
  ASSERT_THAT(save_png(Image(160, 120, 1), mask), IsOk());
  const DerivedTake second{.rig = {}, .first = 1, .end = 2, .how = "trim", .label = ""};
  ASSERT_THAT(derive_take(*open(own), second, folder_ / "part"), IsOk());
  EXPECT_EQ(*read_file(occluder_file(TakeLayout(folder_ / "part"), "cam02")), *read_file(mask));
}

TEST_F(ANewTake, OfSeveralHasTheirPicturesOneAfterTheOther) {
  const auto take = open(recorded());
  for (const auto& [name, first, end] : {std::tuple{"a", 0, 1}, {"b", 1, 4}})
    ASSERT_THAT(derive_take(*take, {.rig = {}, .first = first, .end = end, .how = "trim", .label = ""},
                            folder_ / name),
                IsOk());
  const Result<JoinReport> report = join_takes({folder_ / "a", folder_ / "b"}, folder_ / "both", nullptr);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->frames, 4);
  EXPECT_THAT(report->notes, IsEmpty()) << "their times follow one another";
  const auto made = open(folder_ / "both");
  for (int f = 0; f < 4; ++f) {
    EXPECT_EQ(picture(*made, 4, f), picture(*take, 4, f));
    EXPECT_EQ(made->rows(4)[static_cast<std::size_t>(f)].info.exposure_start,
              take->rows(4)[static_cast<std::size_t>(f)].info.exposure_start);
  }
  EXPECT_TRUE(is_intact(folder_ / "both"));
}

TEST_F(ANewTake, OfSeveralThatOverlapBeginsTheLaterOneAFrameAfter) {
  const Result<JoinReport> report = join_takes({recorded(), recorded()}, folder_ / "twice", nullptr);
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->notes, Contains(HasSubstr("one frame later")));
  const auto made = open(folder_ / "twice");
  EXPECT_EQ(made->frame_count(), 8);
  EXPECT_THAT(made->warnings(), IsEmpty()) << "times and numbers grow";
}

TEST_F(ANewTake, OfSeveralSaysWhoseTimeCodeItLeavesOut) {
  const fs::path coded = folder_ / "coded";
  fs::copy(recorded(), coded, fs::copy_options::recursive);
  ASSERT_THAT(
      capture::save_time_code({.rate = {}, .frames = 90'000, .at = {}, .from = "hand"}, TakeLayout(coded)),
      IsOk());
  const Result<JoinReport> report = join_takes({recorded(), coded}, folder_ / "twice", nullptr);
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->notes, Contains(HasSubstr("the time code of " + coded.string() + " is left out")));
  EXPECT_FALSE(fs::exists(capture::time_code_file(TakeLayout(folder_ / "twice"))));
}

TEST_F(ANewTake, IsNotJoinedOfOtherCamerasOrRigs) {
  const auto take = open(recorded());
  Rig moved = take->rig();
  moved.cameras[0].model.cx += 1;
  ASSERT_THAT(derive_take(*take, {.rig = moved, .how = "set-rig", .label = ""}, folder_ / "moved"), IsOk());
  EXPECT_THAT(join_takes({recorded(), folder_ / "moved"}, folder_ / "both", nullptr),
              FailsWith(ErrorCode::InvalidArgument, "set-rig"));
  EXPECT_THAT(join_takes({recorded()}, folder_ / "both", nullptr),
              FailsWith(ErrorCode::InvalidArgument, "two takes"));
  EXPECT_THAT(join_takes({recorded(), folder_ / "none"}, folder_ / "both", nullptr),
              FailsWith(ErrorCode::NotFound, "none"));
  EXPECT_EQ(left_over(), 1u);
}

TEST_F(ANewTake, WithADamagedWordOfItsOriginIsRefused) {
  const auto take = open(recorded());
  ASSERT_THAT(
      derive_take(*take, {.rig = {}, .first = 0, .end = 2, .how = "trim", .label = ""}, folder_ / "part"),
      IsOk());
  const fs::path file = folder_ / "part" / "derived.json";
  const std::string whole = *read_file(file);
  for (std::size_t n = 0; n + 2 < whole.size(); n += 7) {
    ASSERT_THAT(write_file(file, whole.substr(0, n)), IsOk());
    EXPECT_THAT(capture::TakeReader::open(folder_ / "part"), FailsWith(ErrorCode::BadData, "derived.json"))
        << n;
  }
}

TEST_F(ANewTake, IsListedWithItsVerdict) {
  const auto take = open(recorded());
  for (const char* name : {"a-whole", "b-failed", "c-broken"})
    ASSERT_THAT(
        derive_take(*take, {.rig = {}, .first = 0, .end = 3, .how = "trim", .label = ""}, folder_ / name),
        IsOk());
  ASSERT_THAT(write_file(folder_ / "b-failed" / "quality.json",
                         R"({"verdict": "FAIL", "complaints": ["cam00 lost 7"]})"),
              IsOk());
  ASSERT_THAT(write_file(folder_ / "c-broken" / "rig.json", "{"), IsOk());
  fs::create_directory(folder_ / "no-take");
  const Result<std::vector<ListedTake>> takes = list_takes(folder_.path());
  ASSERT_THAT(takes, IsOk());
  ASSERT_EQ(takes->size(), 3u);
  EXPECT_EQ((*takes)[0].verdict, "whole");
  EXPECT_EQ((*takes)[0].facts.frames, 3);
  EXPECT_EQ((*takes)[1].verdict, "FAIL: cam00 lost 7");
  EXPECT_THAT((*takes)[2].verdict, HasSubstr("does not open"));
  EXPECT_THAT(list_takes(folder_ / "nowhere"), FailsWith(ErrorCode::NotFound, "nowhere"));
  const Result<Image> small = thumbnail(*open(folder_ / "a-whole"), 64);
  ASSERT_THAT(small, IsOk());
  EXPECT_LE(small->width, 64);
}

}  // namespace
}  // namespace floatstage::pipeline
