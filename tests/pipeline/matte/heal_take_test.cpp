#include "pipeline/matte/heal_take.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "pipeline/matte/edited_camera.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;
using testing::Not;

/// Eight cameras around the blue stage, whose cloth has the colour of the performer's stripes and trousers:
/// no key stands out, and each lacks as much. Nobody shot plates, which would tell (ADR 0293).
class HealTake : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shot_ = new TempFolder;
    SynthesizeOptions options;
    options.out = *shot_ / "take";
    options.rig.width = 320;
    options.rig.height = 240;
    options.studio.samples = 4;
    options.studio.stage = SyntheticStage::BlueCyclorama;
    options.studio.defects.noise = 1;
    options.frames = 2;
    ASSERT_THAT(synthesize_take(options), IsOk());
    fs::remove_all(options.out / "plates");
  }
  static void TearDownTestSuite() { delete shot_; }
  void SetUp() override {
    for (const fs::path& take : {take_, other_}) fs::copy(*shot_ / "take", take, fs::copy_options::recursive);
  }
  static Result<MatteReport> matte(const fs::path& take, bool redo = false) {
    return matte_take({.take = take, .how = "chroma", .redo = redo, .heal = true, .check = false});
  }
  static std::map<std::string, std::string> mattes_of(const fs::path& take) {
    std::map<std::string, std::string> bytes;
    const auto reader = *capture::TakeReader::open(take);
    for (const RigCamera& camera : reader->rig().cameras)
      for (const int frame : {0, 1})
        if (Result<std::string> one = read_file(TakeLayout(take).matte(camera.serial, frame)))
          bytes[camera.serial + "/" + std::to_string(frame)] = std::move(*one);
    return bytes;
  }
  static double iou_of(const fs::path& take) {
    double sum = 0;
    const auto reader = *capture::TakeReader::open(take);
    for (const RigCamera& camera : reader->rig().cameras)
      sum += iou(make_matte({}, *load_png(TakeLayout(take).matte(camera.serial, 0))),
                 make_matte({}, *load_png(TakeLayout(take).truth().matte(camera.serial, 0))));
    return sum / static_cast<double>(reader->rig().cameras.size());
  }
  // A person's word on one camera: nothing is subject in a corner, where nothing was, in frame 0.
  static CameraEdits masked() {
    CameraEdits edits;
    edits.masks.push_back({.label = MatteLabel::Background,
                           .polygon = {{0, 0}, {20, 0}, {20, 20}, {0, 20}},
                           .first = 0,
                           .last = 0});
    return edits;
  }
  // A click in frame 0 where a matte is opaque, with room around.
  static CameraEdits click_inside(const Image& matte) {
    for (int y = 4; y + 4 < matte.height; ++y)
      for (int x = 4; x + 4 < matte.width; ++x) {
        bool full = true;
        for (int v = -4; v <= 4 && full; ++v)
          for (int u = -4; u <= 4 && full; ++u) full = *matte.at(x + u, y + v) == 255;
        if (full) return {{{0, {{MatteLabel::Foreground, 2, {{x + 0.5, y + 0.5}}}}}}, {}};
      }
    return {};
  }
  static void write_edits(const fs::path& take, const CameraEdits& edits) {
    fs::create_directories(TakeLayout(take).mattes());
    ASSERT_THAT(save_matte_edits(MatteEdits{{{"cam03", edits}}}, TakeLayout(take).edits()), IsOk());
  }

  static inline TempFolder* shot_ = nullptr;
  TempFolder folder_;
  const fs::path take_ = folder_ / "take", other_ = folder_ / "other";
};

TEST_F(HealTake, MattesAreTheSameWhetherTheirVerbOrProcessMakesThem) {
  const Result<MatteReport> by_matte = matte(take_);
  ASSERT_THAT(by_matte, IsOk());
  EXPECT_THAT(by_matte->healed, Not(IsEmpty()));
  const Result<ProcessReport> by_process = process_take({.take = other_, .matte = "chroma"});
  ASSERT_THAT(by_process, IsOk());
  EXPECT_EQ(by_process->healed.size(), by_matte->healed.size());
  const auto mattes = mattes_of(take_);
  EXPECT_EQ(mattes.size(), 16u);
  EXPECT_TRUE(mattes == mattes_of(other_));
  EXPECT_GE(iou_of(take_), 0.93);

  const Result<ProcessReport> after = process_take({.take = take_});
  ASSERT_THAT(after, IsOk());
  EXPECT_EQ(after->mattes.made, 0);
  EXPECT_THAT(after->healed, IsEmpty()) << "what was compared is compared once";
  EXPECT_TRUE(mattes_of(take_) == mattes);
  const Result<MatteReport> again = matte(take_), behind = matte(other_);
  ASSERT_TRUE(again && behind);
  EXPECT_EQ(again->made + behind->made, 0);
  EXPECT_THAT(again->healed, IsEmpty());
  EXPECT_THAT(behind->healed, IsEmpty());
  EXPECT_TRUE(mattes_of(other_) == mattes);
}

TEST_F(HealTake, MadeAgainTheyAreWhatTheyWere) {
  ASSERT_THAT(matte(take_), IsOk());
  const auto mattes = mattes_of(take_);
  const Result<MatteReport> redone = matte(take_, true);
  ASSERT_THAT(redone, IsOk());
  EXPECT_EQ(redone->made, 16);
  EXPECT_THAT(redone->healed, Not(IsEmpty()));
  EXPECT_TRUE(mattes_of(take_) == mattes);
}

TEST_F(HealTake, WhatAPersonEditedIsAWitnessAndStaysAsItIs) {
  write_edits(other_, masked());
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const std::string edited = mattes_of(other_).at("cam03/0");
  const Result<MatteReport> healed = matte(other_);
  ASSERT_THAT(healed, IsOk());
  EXPECT_THAT(healed->healed, Not(IsEmpty()));
  EXPECT_EQ(mattes_of(other_).at("cam03/0"), edited);
  const CameraRecord record = (*load_matte_record(TakeLayout(other_))).at("cam03");
  EXPECT_FALSE(record.healed.contains(0));
  EXPECT_TRUE(record.healed.contains(1)) << "the mask holds in frame 0 alone";
}

// A click on the performer, whom the key has there: nothing changes for it, and nothing is kept from healing.
TEST_F(HealTake, AStrokeThatChangesNothingKeepsNothingButWhatItMarks) {
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const Image key = *load_png(TakeLayout(other_).matte("cam03", 0));
  const CameraEdits idle = click_inside(key);
  write_edits(other_, idle);
  const Result<MatteReport> report = matte(other_);
  ASSERT_THAT(report, IsOk());
  EXPECT_FALSE(report->cameras[3].idle.empty()) << "it is named";
  const CameraRecord record = (*load_matte_record(TakeLayout(other_))).at("cam03");
  EXPECT_TRUE(record.healed.contains(0));
  EXPECT_TRUE(record.healed.contains(1));
  ASSERT_THAT(matte(take_), IsOk());
  EXPECT_TRUE(mattes_of(take_) == mattes_of(other_)) << "as without it: what it marks was subject anyway";
  const auto healed_before = mattes_of(take_);
  write_edits(take_, idle);
  ASSERT_THAT(matte(take_), IsOk());
  EXPECT_TRUE(mattes_of(take_) == healed_before) << "nor does one that comes afterwards";
  Image said(key.width, key.height, 1, 128);
  paint_strokes(idle.keyframes[0].strokes, 1, said);
  const Image healed = *load_png(TakeLayout(other_).matte("cam03", 0));
  for (std::size_t p = 0; p < said.pixels.size(); ++p) {
    if (said.pixels[p] != 255) continue;
    ASSERT_EQ(healed.pixels[p], 255);
  }
}

// A person says that a wall beside the performer is none, where the key has nobody: and that holds though
// the others' evidence were to put somebody there.
TEST_F(HealTake, WhatAStrokeThatChangesNothingMarksHoldsAgainstTheOthers) {
  ASSERT_THAT(matte(take_), IsOk());
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const Image healed = *load_png(TakeLayout(take_).matte("cam03", 0)),
              key = *load_png(TakeLayout(other_).matte("cam03", 0));
  CameraEdits no;  // a pixel that healing makes subject, and the key had as nothing
  for (std::size_t p = 0; p < key.pixels.size() && no.keyframes.empty(); ++p)
    if (key.pixels[p] == 0 && healed.pixels[p] == 255)
      no.keyframes = {
          {0,
           {{MatteLabel::Background,
             0.4,
             {{static_cast<double>(p % key.width) + 0.5, static_cast<double>(p / key.width) + 0.5}}}}}};
  ASSERT_FALSE(no.keyframes.empty());
  write_edits(other_, no);
  ASSERT_THAT(matte(other_), IsOk());
  const Eigen::Vector2d at = no.keyframes[0].strokes[0].points[0];
  const Image now = *load_png(TakeLayout(other_).matte("cam03", 0));
  EXPECT_EQ(*now.at(static_cast<int>(at.x()), static_cast<int>(at.y())), 0);
  EXPECT_TRUE((*load_matte_record(TakeLayout(other_))).at("cam03").healed.contains(0));
}

TEST_F(HealTake, FramesThatAStrokeChangesAreKeptAndOthersOfItsCameraHealed) {
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const Image key = *load_png(TakeLayout(other_).matte("cam03", 0)),
              truth = *load_png(TakeLayout(other_).truth().matte("cam03", 0));
  CameraEdits acts;  // one pixel of her that the key lacks, so that nothing hangs together with it elsewhere
  for (std::size_t p = 0; p < key.pixels.size() && acts.keyframes.empty(); ++p)
    if (key.pixels[p] == 0 && truth.pixels[p] == 255)
      acts.keyframes = {
          {0,
           {{MatteLabel::Foreground,
             0.4,
             {{static_cast<double>(p % key.width) + 0.5, static_cast<double>(p / key.width) + 0.5}}}}}};
  ASSERT_FALSE(acts.keyframes.empty());
  write_edits(other_, acts);
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const std::string edited = mattes_of(other_).at("cam03/0");
  ASSERT_THAT(matte(other_), IsOk());
  const CameraRecord record = (*load_matte_record(TakeLayout(other_))).at("cam03");
  EXPECT_TRUE(record.guided.contains(0));
  EXPECT_EQ(mattes_of(other_).at("cam03/0"), edited);
  EXPECT_EQ(record.healed.contains(1), !record.guided.contains(1));
}

TEST_F(HealTake, TheEditorKeepsHealedMattesWhereAStrokeChangesNothing) {
  ASSERT_THAT(matte(take_), IsOk());
  const auto before = mattes_of(take_);
  const Image healed = *load_png(TakeLayout(take_).matte("cam03", 0));
  ASSERT_THAT(matte_take({.take = other_, .how = "chroma", .check = false}), IsOk());
  const CameraEdits idle = click_inside(*load_png(TakeLayout(other_).matte("cam03", 0)));
  ASSERT_TRUE((*load_matte_record(TakeLayout(take_))).at("cam03").healed.contains(0));
  write_edits(take_, idle);
  auto camera = EditedCamera::open({.take = take_, .serial = "cam03"});
  ASSERT_THAT(camera, IsOk());
  EXPECT_THAT(*(*camera)->remake(idle, {}), IsEmpty());
  EXPECT_TRUE(mattes_of(take_) == before);
  EXPECT_FALSE((*camera)->idle().empty()) << "and says that it changes nothing";
  // What the others' evidence made subject, and a person says is none, is none.
  const Image key = *load_png(TakeLayout(other_).matte("cam03", 0));
  CameraEdits no = idle;
  for (std::size_t p = 0; p < key.pixels.size() && no.keyframes[0].strokes.size() < 2; ++p)
    if (key.pixels[p] == 0 && healed.pixels[p] == 255)
      no.keyframes[0].strokes.push_back(
          {MatteLabel::Background,
           0.4,
           {{static_cast<double>(p % static_cast<std::size_t>(key.width)) + 0.5,
             static_cast<double>(p / static_cast<std::size_t>(key.width)) + 0.5}}});
  ASSERT_EQ(no.keyframes[0].strokes.size(), 2U);
  write_edits(take_, no);
  ASSERT_THAT((*camera)->remake(no, {}), IsOk());
  const Eigen::Vector2d at = no.keyframes[0].strokes[1].points[0];
  EXPECT_EQ(
      *load_png(TakeLayout(take_).matte("cam03", 0))->at(static_cast<int>(at.x()), static_cast<int>(at.y())),
      0);
}

TEST_F(HealTake, TheEditorKeepsComparedMattesWhereNobodyEdits) {
  ASSERT_THAT(matte(take_), IsOk());
  const auto before = mattes_of(take_);
  auto camera = EditedCamera::open({.take = take_, .serial = "cam03"});
  ASSERT_THAT(camera, IsOk());
  EXPECT_THAT(*(*camera)->remake({}, {}), IsEmpty());
  EXPECT_TRUE(mattes_of(take_) == before);
  write_edits(take_, masked());
  EXPECT_THAT(*(*camera)->remake(masked(), {}), testing::ElementsAre(0));
  const auto after = mattes_of(take_);
  for (const auto& [name, bytes] : before) EXPECT_EQ(after.at(name) == bytes, name != "cam03/0") << name;
  // The verb has the same bytes of what was edited.
  write_edits(other_, masked());
  ASSERT_THAT(matte(other_), IsOk());
  EXPECT_EQ(mattes_of(other_).at("cam03/0"), after.at("cam03/0"));
}

TEST_F(HealTake, SomeCamerasAloneAreNotCompared) {
  const Result<MatteReport> some = matte_take({.take = take_,
                                               .how = "chroma",
                                               .cameras = {"cam00", "cam01", "cam02", "cam03"},
                                               .heal = true,
                                               .check = false});
  ASSERT_THAT(some, IsOk());
  EXPECT_THAT(some->healed, IsEmpty());
  EXPECT_EQ(mattes_of(take_).size(), 8u);
  ASSERT_THAT(matte(take_), IsOk());
  ASSERT_THAT(matte(other_), IsOk());
  EXPECT_TRUE(mattes_of(take_) == mattes_of(other_));
}

}  // namespace
}  // namespace floatstage::pipeline
