#include "pipeline/process/process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "pipeline/keying.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_check.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

ProcessOptions options_for(const fs::path& take) {
  ProcessOptions options{.take = take, .key = "chroma", .hull = recon::HullOptions{}};
  options.hull->resolution = 48;
  return options;
}

// Every camera's matte of the first instant becomes `alpha`, and the meshes have to be made anew.
void replace_every_matte(const TakeLayout& layout, const Image& alpha) {
  for (const fs::directory_entry& camera : fs::directory_iterator(layout.mattes())) {
    if (!camera.is_directory()) continue;
    ASSERT_THAT(save_png(alpha, layout.matte(camera.path().filename().string(), 0)), IsOk());
  }
  fs::remove_all(layout.meshes());
}

TEST(Process, MakesAMatteForEveryPhotographAndAMeshForEveryInstant) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  const Result<ProcessReport> report = process_take(options_for(take));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->mattes.made, 12);
  EXPECT_EQ(report->meshes.made, 2);
  EXPECT_THAT(report->mattes.failures, IsEmpty());
  EXPECT_THAT(report->meshes.failures, IsEmpty());
  const TakeLayout layout(take);
  for (int f = 0; f < 2; ++f) {
    const Result<Mesh> mesh = load_ply(layout.mesh(f));
    ASSERT_THAT(mesh, IsOk());
    EXPECT_TRUE(recon::check_mesh(*mesh).good()) << recon::check_mesh(*mesh).summary();
  }
}

TEST(Process, KeysTheSyntheticRoomNearlyAsTheTruthHasIt) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  for (const fs::directory_entry& camera : fs::directory_iterator(layout.truth().mattes())) {
    const std::string serial = camera.path().filename();
    const Matte made = make_matte({}, *load_png(layout.matte(serial, 0))),
                truth = make_matte({}, *load_png(layout.truth().matte(serial, 0)));
    EXPECT_GE(iou(made, truth), 0.93) << serial;
  }
}

TEST(Process, DoesOnlyWhatIsMissingInASecondRun) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  const std::string before = *read_file(layout.mesh(1));
  fs::remove(layout.mesh(1));
  const Result<ProcessReport> again = process_take(options_for(take));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->mattes.made, 0);
  EXPECT_EQ(again->mattes.kept, 12);
  EXPECT_EQ(again->meshes.made, 1);
  EXPECT_EQ(again->meshes.kept, 1);
  EXPECT_EQ(*read_file(layout.mesh(1)), before) << "the same input gives the same bytes";
}

TEST(Process, GivesTheSameBytesOnOneThreadAndOnTwo) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ProcessOptions options = options_for(take);
  options.threads = 1;
  ASSERT_THAT(process_take(options), IsOk());
  const TakeLayout layout(take);
  const std::string matte = *read_file(layout.matte("cam01", 1)), mesh = *read_file(layout.mesh(1));
  fs::remove_all(layout.mattes());
  fs::remove_all(layout.meshes());
  options.threads = 2;
  ASSERT_THAT(process_take(options), IsOk());
  EXPECT_EQ(*read_file(layout.matte("cam01", 1)), matte);
  EXPECT_EQ(*read_file(layout.mesh(1)), mesh);
}

TEST(Process, RefusesOtherOptionsThanBeforeUnlessToldToRedo) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  ProcessOptions other = options_for(take);
  other.key = "difference";
  EXPECT_THAT(process_take(other), FailsWith(ErrorCode::AlreadyExists, "--redo"));
  other.redo = true;
  const Result<ProcessReport> redone = process_take(other);
  ASSERT_THAT(redone, IsOk());
  EXPECT_EQ(redone->mattes.made, 6);
  EXPECT_EQ(redone->meshes.made, 1);

  other.hull->contour_tolerance = 1;
  other.redo = false;
  EXPECT_THAT(process_take(other), FailsWith(ErrorCode::AlreadyExists, "hull options"));
}

TEST(Process, KeepsWhatAPersonSaidAboutTheMattesWhenItMakesThemAgain) {
  TempFolder folder;
  ProcessOptions options = options_for(small_take(folder, 1));
  ASSERT_THAT(process_take(options), IsOk());
  const TakeLayout layout(options.take);
  ASSERT_THAT(write_file(layout.edits(), "{}"), IsOk());
  options.key = "difference";
  options.redo = true;
  ASSERT_THAT(process_take(options), IsOk());
  EXPECT_TRUE(fs::exists(layout.edits()));
}

TEST(Process, GoesOnWithTheKeyerOfTheFirstRunWhenNoneIsNamed) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  ProcessOptions unnamed = options_for(take);
  unnamed.key.reset();
  const Result<ProcessReport> again = process_take(unnamed);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->mattes.kept, 6);
}

TEST(Process, GoesOnWithTheHullOptionsOfTheFirstRunWhenNoneAreGiven) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ProcessOptions first = options_for(take);
  first.hull->contour_tolerance = 1.5;
  first.hull->voting = recon::HullVoting::MofN;
  first.hull->votes = 5;
  ASSERT_THAT(process_take(first), IsOk());
  const TakeLayout layout(take);
  const std::string mesh = *read_file(layout.mesh(1));
  fs::remove(layout.mesh(1));
  ProcessOptions unsaid = options_for(take);
  unsaid.hull.reset();
  const Result<ProcessReport> again = process_take(unsaid);
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->meshes.kept, 1);
  EXPECT_EQ(again->meshes.made, 1);
  EXPECT_EQ(*read_file(layout.mesh(1)), mesh) << "with the tolerance and the votes of the first run";
}

TEST(Process, SweepsUpWhatAKilledRunLeftHalfWritten) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  const TakeLayout layout(take);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const fs::path half = temporary_name(layout.mesh(0));
  ASSERT_THAT(write_file(half.parent_path() / "x", "half"), IsOk());
  fs::rename(half.parent_path() / "x", half);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  EXPECT_FALSE(fs::exists(half));
}

TEST(Process, ReportsABadMatteByNameAndGoesOnWithTheOtherFrames) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  ASSERT_THAT(save_png(Image(10, 10, 1), layout.matte("cam02", 0)), IsOk());
  fs::remove_all(layout.meshes());
  const Result<ProcessReport> report = process_take(options_for(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->meshes.failures.size(), 1u);
  EXPECT_THAT(report->meshes.failures[0], HasSubstr("cam02"));
  EXPECT_EQ(report->meshes.made, 1);
}

TEST(Process, LeavesTheGapsOfARecordingOpen) {
  TempFolder folder;
  SynthesizeOptions studio;
  studio.out = folder / "take";
  studio.rig.width = 160;
  studio.rig.height = 120;
  studio.studio.samples = 1;
  studio.studio.defects.dropped_frames = 0.3;
  studio.frames = 2;
  ASSERT_THAT(synthesize_take(studio), IsOk());
  const Result<ProcessReport> report = process_take(options_for(studio.out));
  ASSERT_THAT(report, IsOk());
  EXPECT_GT(report->mattes.gaps, 0);
  EXPECT_EQ(report->mattes.made + report->mattes.gaps, 16);
  EXPECT_EQ(report->meshes.made, 2) << "a camera that missed the instant does not carve";
}

TEST(Process, TakesAnEmptyStageAsAnEmptyMesh) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  replace_every_matte(layout, Image(160, 120, 1));
  const Result<ProcessReport> report = process_take(options_for(take));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->empty_frames, 1);
  EXPECT_TRUE(load_ply(layout.mesh(0))->empty());
}

TEST(Process, NamesAMatteThatIsAllForeground) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  replace_every_matte(layout, Image(160, 120, 1, 255));
  const Result<ProcessReport> report = process_take(options_for(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->meshes.failures.size(), 1u);
  EXPECT_THAT(report->meshes.failures[0], HasSubstr("the subject fills the image"));
}

TEST(Process, SaysWhichFolderIsNoTake) {
  TempFolder folder;
  EXPECT_THAT(process_take(options_for(folder.path())),
              FailsWith(ErrorCode::NotFound, folder.path().string()));
  EXPECT_THAT(process_take(options_for(folder / "nowhere")), FailsWith(ErrorCode::NotFound, "nowhere"));
}

TEST(Process, ListsTheKeyersWhenItsNameIsUnknown) {
  TempFolder folder;
  ProcessOptions options = options_for(small_take(folder, 1));
  options.key = "croma";
  EXPECT_THAT(process_take(options), FailsWith(ErrorCode::InvalidArgument, "chroma"));
  EXPECT_FALSE(fs::exists(TakeLayout(options.take).mattes())) << "nothing half-written";
}

}  // namespace
}  // namespace floatstage::pipeline
