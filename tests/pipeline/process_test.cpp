#include "pipeline/process/process.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/mesh_io.h"
#include "core/png.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_check.h"
#include "recon/mesh/mesh_mask.h"
#include "tests/support/broken_mattes.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

ProcessOptions options_for(const fs::path& take) {
  ProcessOptions options{.take = take, .matte = "chroma", .hull = recon::HullOptions{}};
  options.hull->resolution = 48;
  return options;
}

// Every camera's matte of the first instant becomes `alpha`.
void replace_every_matte(const TakeLayout& layout, const Image& alpha) {
  for (const fs::directory_entry& camera : fs::directory_iterator(layout.mattes())) {
    if (!camera.is_directory()) continue;
    ASSERT_THAT(save_png(alpha, layout.matte(camera.path().filename().string(), 0)), IsOk());
  }
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

// The garbage mask cuts the dancer's middle away, in one camera and one frame.
MatteEdits edits_of_one_frame(int frame) {
  MatteEdits edits;
  edits.cameras["cam01"].masks.push_back(
      {MatteLabel::Background, {{0, 40}, {160, 40}, {160, 70}, {0, 70}}, frame, frame});
  return edits;
}

TEST(Process, MakesOnlyTheMeshesAgainThatAnEditTouches) {
  TempFolder folder;
  const fs::path take = small_take(folder, 3);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  const std::string touched = *read_file(layout.mesh(2)), untouched = *read_file(layout.mesh(1));
  const auto time = fs::last_write_time(layout.mesh(1));
  ASSERT_THAT(save_matte_edits(edits_of_one_frame(2), layout.edits()), IsOk());
  const Result<ProcessReport> report = process_take({.take = take});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->mattes.made, 1);
  EXPECT_EQ(report->mattes.kept, 17);
  EXPECT_EQ(report->meshes.made, 1);
  EXPECT_EQ(report->meshes.kept, 2);
  EXPECT_NE(*read_file(layout.mesh(2)), touched);
  EXPECT_EQ(*read_file(layout.mesh(1)), untouched);
  EXPECT_EQ(fs::last_write_time(layout.mesh(1)), time);
  ASSERT_THAT(save_matte_edits({}, layout.edits()), IsOk());
  ASSERT_THAT(process_take({.take = take}), IsOk());
  EXPECT_EQ(*read_file(layout.mesh(2)), touched) << "the edit was taken back";
  EXPECT_EQ(process_take({.take = take})->meshes.made, 0);
}

TEST(Process, MakesAMeshAgainWhoseMatteSomebodyReplaced) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  ASSERT_THAT(save_png(*load_png(layout.truth().matte("cam04", 0)), layout.matte("cam04", 0)), IsOk());
  const Result<ProcessReport> report = process_take({.take = take});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->mattes.made, 0);
  EXPECT_EQ(report->mattes.others, 1);
  EXPECT_EQ(report->meshes.made, 1);
}

TEST(Process, GoesOnWithATakeWhoseMattesWereMadeByHand) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  const TakeLayout layout(take);
  fs::copy(layout.truth().mattes(), layout.mattes(), fs::copy_options::recursive);
  for (const bool redo : {false, true}) {
    const Result<ProcessReport> report = process_take({.take = take, .redo = redo});
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->mattes.made, 0);
    EXPECT_EQ(report->mattes.others, 12);
    EXPECT_EQ(report->meshes.made, 2);
  }
  EXPECT_EQ(*read_file(layout.matte("cam02", 1)), *read_file(layout.truth().matte("cam02", 1)));
}

TEST(Process, NeverTouchesAMeshThatSomebodyElseMade) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  const TakeLayout layout(take);
  ASSERT_THAT(save_ply(*load_ply(layout.truth().mesh(1)), layout.mesh(1)), IsOk());
  const std::string sculpted = *read_file(layout.mesh(1));
  ASSERT_THAT(save_png(*load_png(layout.truth().matte("cam04", 1)), layout.matte("cam04", 1)), IsOk());
  ProcessOptions again = options_for(take);
  again.redo = true;
  const Result<ProcessReport> report = process_take(again);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->meshes.made, 1);
  EXPECT_EQ(report->meshes.others, 1);
  EXPECT_EQ(*read_file(layout.mesh(1)), sculpted);
}

TEST(Process, TriesOneInstantFirst) {
  TempFolder folder;
  const fs::path take = small_take(folder, 3);
  ProcessOptions one = options_for(take);
  one.frames = {1};
  const Result<ProcessReport> tried = process_take(one);
  ASSERT_THAT(tried, IsOk());
  EXPECT_EQ(tried->frames, 1);
  EXPECT_EQ(tried->mattes.made, 6);
  EXPECT_EQ(tried->meshes.made, 1);
  const std::string mesh = *read_file(TakeLayout(take).mesh(1));
  const Result<ProcessReport> all = process_take({.take = take});
  ASSERT_THAT(all, IsOk());
  EXPECT_EQ(all->mattes.made, 12);
  EXPECT_EQ(all->meshes.made, 2);
  EXPECT_EQ(*read_file(TakeLayout(take).mesh(1)), mesh);
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
  other.matte = "difference";
  EXPECT_THAT(process_take(other), FailsWith(ErrorCode::AlreadyExists, "--redo"));
  other.redo = true;
  const Result<ProcessReport> redone = process_take(other);
  ASSERT_THAT(redone, IsOk());
  EXPECT_EQ(redone->mattes.made, 6);
  EXPECT_EQ(redone->meshes.made, 1);

  other.hull->contour_tolerance = 1;
  other.redo = false;
  EXPECT_THAT(process_take(other), FailsWith(ErrorCode::AlreadyExists, "hull options"));
  other.redo = true;
  const Result<ProcessReport> same = process_take(other);
  ASSERT_THAT(same, IsOk());
  EXPECT_EQ(same->mattes.made, 6) << "redo redoes";
  EXPECT_EQ(same->meshes.made, 1);
}

TEST(Process, KeepsWhatAPersonSaidAboutTheMattesWhenItMakesThemAgain) {
  TempFolder folder;
  ProcessOptions options = options_for(small_take(folder, 1));
  ASSERT_THAT(process_take(options), IsOk());
  const TakeLayout layout(options.take);
  ASSERT_THAT(save_matte_edits({}, layout.edits()), IsOk());
  options.matte = "difference";
  options.redo = true;
  ASSERT_THAT(process_take(options), IsOk());
  EXPECT_TRUE(fs::exists(layout.edits()));
}

TEST(Process, GoesOnWithTheKeyerOfTheFirstRunWhenNoneIsNamed) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ASSERT_THAT(process_take(options_for(take)), IsOk());
  ProcessOptions unnamed = options_for(take);
  unnamed.matte.reset();
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

// The upper half of what the matte shows is gone.
void cut_upper_half(const fs::path& matte) {
  Image alpha = *load_png(matte);
  test::cut_upper_half(alpha);
  ASSERT_THAT(save_png(alpha, matte), IsOk());
}

TEST(Process, NamesTheCameraThatLacksHalfTheBodyInEveryRunWithAPicture) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ProcessOptions options = options_for(take);
  options.hull->voting = recon::HullVoting::Auto;
  ASSERT_THAT(process_take(options), IsOk());
  const TakeLayout layout(take);
  const Mesh whole = *load_ply(layout.mesh(1));
  cut_upper_half(layout.matte("cam02", 1));
  fs::remove_all(layout.meshes());
  for (const int made : {2, 0}) {
    const Result<ProcessReport> report = process_take(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->meshes.made, made);
    EXPECT_EQ(report->contradictory_frames, 0);
    ASSERT_EQ(report->faults.size(), 1u);
    const SilhouetteFault& fault = report->faults[0];
    EXPECT_EQ(fault.serial, "cam02");
    EXPECT_EQ(fault.frames, 1);
    EXPECT_EQ(fault.worst, 1);
    EXPECT_NEAR(fault.lost, 0.5, 0.2);
    EXPECT_TRUE(fs::exists(fault.picture));
    EXPECT_THAT(sentence(fault), HasSubstr("camera 'cam02' lacks"));
  }
  EXPECT_NEAR(signed_volume(*load_ply(layout.mesh(1))) / signed_volume(whole), 1, 0.1);
}

TEST(Process, TakesThePictureOfAFaultAwayThatIsNoMore) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ProcessOptions options = options_for(take);
  options.hull->voting = recon::HullVoting::Auto;
  ASSERT_THAT(process_take(options), IsOk());
  const TakeLayout layout(take);
  const std::string whole = *read_file(layout.matte("cam02", 1));
  cut_upper_half(layout.matte("cam02", 1));
  const Result<ProcessReport> wrong = process_take(options);
  ASSERT_THAT(wrong, IsOk());
  ASSERT_EQ(wrong->faults.size(), 1u);
  ASSERT_TRUE(fs::exists(wrong->faults[0].picture));
  const fs::path somebodys = layout.meshes() / "faults" / "note.png";
  ASSERT_THAT(write_file(somebodys, "of somebody"), IsOk());
  ASSERT_THAT(write_file(layout.matte("cam02", 1), whole), IsOk());
  const Result<ProcessReport> right = process_take(options);
  ASSERT_THAT(right, IsOk());
  EXPECT_THAT(right->faults, IsEmpty());
  EXPECT_FALSE(fs::exists(wrong->faults[0].picture));
  EXPECT_TRUE(fs::exists(somebodys));
}

TEST(Process, StatesWhatABudgetOfTrianglesCostsInEveryRun) {
  TempFolder folder;
  const fs::path take = small_take(folder);
  ProcessOptions options = options_for(take);
  EXPECT_FALSE((*process_take(options)).cleanup);
  options.redo = true;
  options.hull->cleanup.triangles = 400;
  double stated = 0;
  for (int run = 0; run < 2; ++run, options.redo = false) {
    const Result<ProcessReport> report = process_take(options);
    ASSERT_THAT(report, IsOk());
    ASSERT_TRUE(report->cleanup);
    EXPECT_EQ(report->cleanup->meshes, 2);
    EXPECT_EQ(report->cleanup->most_triangles, 400);
    EXPECT_GT(report->cleanup->iou_loss, 0);
    EXPECT_THAT(sentence(*report->cleanup), HasSubstr("up to 400 triangles a mesh"));
    EXPECT_TRUE(run == 0 || report->cleanup->iou_loss == stated);
    stated = report->cleanup->iou_loss;
  }
  // It is what the worst camera's silhouette lost.
  const auto reader = *capture::TakeReader::open(take);
  const int frame = process_take(options)->cleanup->frame;
  const std::vector<Matte> mattes = *load_mattes(*reader, frame);
  recon::HullOptions whole = *options.hull;
  whole.cleanup = {};
  const Mesh before = recon::visual_hull(reader->rig(), mattes, whole)->mesh,
             after = *load_ply(TakeLayout(take).mesh(frame));
  double lost = 0;
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    const RigCamera& camera = reader->rig().cameras[c];
    lost = std::max(lost, iou(recon::mesh_mask(camera, before), mattes[c]) -
                              iou(recon::mesh_mask(camera, after), mattes[c]));
  }
  EXPECT_NEAR(lost, stated, 1e-6);
}

TEST(Process, DoesNotTrustHullsOfMattesThatContradictOneAnother) {
  TempFolder folder;
  const fs::path take = small_take(folder, 1);
  ProcessOptions options = options_for(take);
  options.hull->voting = recon::HullVoting::Auto;
  const Result<ProcessReport> right = process_take(options);
  ASSERT_THAT(right, IsOk());
  EXPECT_EQ(right->contradictory_frames, 0);
  const TakeLayout layout(take);
  for (const char* camera : {"cam00", "cam02", "cam04"}) {  // upside down
    Image alpha = *load_png(layout.matte(camera, 0));
    std::reverse(alpha.pixels.begin(), alpha.pixels.end());
    ASSERT_THAT(save_png(alpha, layout.matte(camera, 0)), IsOk());
  }
  fs::remove_all(layout.meshes());
  for (const int made : {1, 0}) {
    const Result<ProcessReport> wrong = process_take(options);
    ASSERT_THAT(wrong, IsOk());
    EXPECT_EQ(wrong->meshes.made, made);
    EXPECT_EQ(wrong->contradictory_frames, 1);
  }
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
  options.matte = "croma";
  EXPECT_THAT(process_take(options), FailsWith(ErrorCode::InvalidArgument, "chroma"));
  EXPECT_FALSE(fs::exists(TakeLayout(options.take).mattes())) << "nothing half-written";
}

}  // namespace
}  // namespace floatstage::pipeline
