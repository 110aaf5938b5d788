#include "pipeline/matte/label_take.h"

#include <filesystem>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "pipeline/chosen_take.h"
#include "pipeline/evaluate/evaluate_mattes.h"
#include "pipeline/export/export_colmap.h"
#include "pipeline/label_record.h"
#include "pipeline/plan/process_plan.h"
#include "pipeline/process/process.h"
#include "pipeline/scene_loader.h"
#include "pipeline/subject.h"
#include "tests/support/small_take.h"

// Two performers who walk past one another, and who is who.
namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

// A take of two, with true mattes of both together.
fs::path take_of_two(const TempFolder& folder, SyntheticCast cast, int frames, int width = 200,
                     double fps = 12.5) {
  SynthesizeOptions options;
  options.out = folder / "take";
  options.rig = {.cameras = 8, .width = width, .height = width * 3 / 4};
  options.studio.samples = 4;
  options.studio.frame_rate = fps;
  options.studio.cast = cast;
  options.frames = frames;
  EXPECT_THAT(synthesize_take(options), IsOk());
  const TakeLayout layout(options.out);
  for (int c = 0; c < options.rig.cameras; ++c)
    for (int f = 0; f < frames; ++f) {
      const std::string serial = text("cam0", c);
      fs::create_directories(layout.mattes() / serial);
      fs::copy_file(layout.truth().matte(serial, f), layout.matte(serial, f));
    }
  return options.out;
}

// The middle of a label's true matte, where a person would click.
LabelClick click_on(const fs::path& take, const std::string& label, const std::string& serial, int frame) {
  const Image truth = *load_png(TakeLayout(take).truth().label_matte(serial, label, frame));
  LabelClick click{label, serial, frame, 0, 0};
  int best = -1;
  for (int y = 2; y < truth.height - 2; ++y)
    for (int x = 2; x < truth.width - 2; ++x) {
      int full = 0;  // how far it is covered to each side
      while (full < x && full<truth.width - 1 - x&& * truth.at(x - full, y)> 250 &&
             *truth.at(x + full, y) > 250)
        ++full;
      if (full > best) best = full, click.x = x + 0.5, click.y = y + 0.5;
    }
  return click;
}

LabelChoice only(const std::string& label) { return {{label}, {}}; }
LabelChoice without(std::vector<std::string> labels) { return {{}, std::move(labels)}; }

// IoU over these cameras and frames.
double iou_in(const fs::path& take, const std::string& label, const std::vector<std::string>& serials,
              int first, int end) {
  const TakeLayout layout(take);
  double both = 0, either = 0;
  for (const std::string& serial : serials)
    for (int f = first; f < end; ++f) {
      const Image is = *load_png(layout.label_matte(serial, label, f)),
                  real = *load_png(layout.truth().label_matte(serial, label, f));
      for (std::size_t p = 0; p < is.pixels.size(); ++p) {
        const bool a = is.pixels[p] >= 128, b = real.pixels[p] >= 128;
        both += a && b, either += a || b;
      }
    }
  return both / either;
}

double iou_of(const fs::path& take, const std::string& label, int first, int end) {
  std::vector<std::string> all;
  for (int c = 0; c < 8; ++c) all.push_back(text("cam0", c));
  return iou_in(take, label, all, first, end);
}

LabelTakeOptions clicks_of(const fs::path& take, int frame = 0) {
  LabelTakeOptions options{.threads = 2};
  options.said = LabelsSaid{};
  for (const char* label : {"first", "second"})
    options.said->clicks.push_back(click_on(take, label, "cam00", frame));
  return options;
}

TEST(LabelTake, FollowsTwoWhoCrossFromOneClickEach) {
  const TempFolder folder;
  const fs::path take = take_of_two(folder, SyntheticCast::Two, 24);
  const Result<LabelTakeReport> report = label_take(take, clicks_of(take));
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, IsEmpty());
  EXPECT_EQ(report->made, 2 * 8 * 24);
  for (const char* label : {"first", "second"}) {
    EXPECT_GE(iou_of(take, label, 0, 24), 0.95) << label;
    for (int f = 0; f < 24; ++f) EXPECT_GE(iou_of(take, label, f, f + 1), 0.85) << label << " in frame " << f;
    EXPECT_GE(iou_of(take, label, 20, 24), 0.96) << label << " after they crossed";
  }
  // They add up to the sum, to the last digit.
  const TakeLayout layout(take);
  for (const int f : {0, 12, 23}) {
    const Image sum = *load_png(layout.matte("cam03", f)),
                a = *load_png(layout.label_matte("cam03", "first", f)),
                b = *load_png(layout.label_matte("cam03", "second", f));
    for (std::size_t p = 0; p < sum.pixels.size(); ++p) ASSERT_EQ(a.pixels[p] + b.pixels[p], sum.pixels[p]);
  }
}

TEST(LabelTake, SaysWhereTwoOfTheSameLookAreOneBody) {
  const TempFolder folder;
  const fs::path take = take_of_two(folder, SyntheticCast::Alike, 9, 100, 5);
  const Result<LabelTakeReport> report = label_take(take, clicks_of(take));
  ASSERT_THAT(report, IsOk());
  ASSERT_THAT(report->doubts, testing::Not(IsEmpty()));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("have the same colours"));
  const Result<LabelTakeReport> again = label_take(take, {});
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 0);
  EXPECT_EQ(again->doubts.size(), report->doubts.size()) << "until it is made another way";
}

// Strokes of mattes/edits.json, the middle of each label's matte marked with this radius.
MatteEdits strokes_of(const std::vector<LabelClick>& clicks, double radius) {
  MatteEdits edits;
  for (const LabelClick& click : clicks) {
    std::vector<MatteKeyframe>& keyframes = edits.cameras[click.serial].keyframes;
    if (keyframes.empty() || keyframes.back().frame != click.frame) keyframes.push_back({click.frame, {}});
    keyframes.back().strokes.push_back({MatteLabel::Foreground, radius, {{click.x, click.y}}, click.label});
  }
  return edits;
}

class TwoApart : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    take_of_two(*shared_, SyntheticCast::Two, 2, 100);
  }
  static void TearDownTestSuite() { delete shared_; }
  TwoApart() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }
  fs::path masks_of(const std::string& label, const std::string& serial, int frame) const {
    const fs::path file = folder_ / ("masks " + label) / serial / layout_.matte(serial, frame).filename();
    fs::create_directories(file.parent_path());
    fs::copy_file(layout_.truth().label_matte(serial, label, frame), file,
                  fs::copy_options::overwrite_existing);
    return folder_ / ("masks " + label);
  }
  Result<LabelTakeReport> say(LabelsSaid said) const {
    return label_take(take_, {.said = std::move(said), .threads = 2});
  }
  LabelsSaid both_clicked() const { return *clicks_of(take_).said; }
  // A stroke of each, the first's in cam00 and the second's in cam03, in these frames.
  void stroke_each(int first, int second) const {
    ASSERT_THAT(save_matte_edits(strokes_of({click_on(take_, "first", "cam00", first),
                                             click_on(take_, "second", "cam03", second)},
                                            1.5),
                                 layout_.edits()),
                IsOk());
  }
  // The mattes of these cameras lack the second body, as a key does that keeps its largest island.
  void lose_the_second(const std::vector<std::string>& serials, const std::vector<int>& frames) const {
    for (const std::string& serial : serials)
      for (const int f : frames)
        fs::copy_file(layout_.truth().label_matte(serial, "first", f), layout_.matte(serial, f),
                      fs::copy_options::overwrite_existing);
  }

  static TempFolder* shared_;
  const TempFolder folder_;
  const fs::path take_ = folder_ / "take";
  const TakeLayout layout_{take_};
};
TempFolder* TwoApart::shared_ = nullptr;

TEST_F(TwoApart, AreToldApartByMasksOfOneCamera) {
  const LabelsSaid said{
      {{"first", masks_of("first", "cam02", 0)}, {"second", masks_of("second", "cam02", 0)}}, {}};
  ASSERT_THAT(say(said), IsOk());
  for (const char* label : {"first", "second"}) EXPECT_GE(iou_of(take_, label, 0, 2), 0.93) << label;
  EXPECT_TRUE(fs::exists(layout_.label_masks() / "first/cam02/000000.png"))
      << "what was said stays in the take";
}

TEST_F(TwoApart, AreMadeAnewWhenAMatteHasChanged) {
  ASSERT_EQ(say(both_clicked())->made, 32);
  EXPECT_EQ(label_take(take_, {})->kept, 32);
  Image sum = *load_png(layout_.matte("cam01", 1));
  *sum.at(0, 0) = 255;
  ASSERT_THAT(save_png(sum, layout_.matte("cam01", 1)), IsOk());
  EXPECT_THAT(open_chosen(take_, only("first")), FailsWith(ErrorCode::NotFound, "older than the matte"));
  EXPECT_EQ(label_take(take_, {})->made, 32);
  EXPECT_THAT(open_chosen(take_, only("first")), IsOk());
}

TEST_F(TwoApart, LeaveSomebodysLabelMattesAlone) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const fs::path file = layout_.label_matte("cam01", "first", 1);
  const Image theirs = *load_png(layout_.truth().label_matte("cam01", "first", 1));
  ASSERT_THAT(save_png(theirs, file), IsOk());
  const Result<LabelTakeReport> report = label_take(take_, {});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->others, 1);
  EXPECT_EQ(*load_png(file), theirs);
}

TEST_F(TwoApart, HaveHullsOfTheirOwn) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const auto size_of = [&](LabelChoice choice) {
    const Result<ProcessReport> report =
        process_take({.take = take_, .frames = {0}, .threads = 2, .labels = choice});
    EXPECT_THAT(report, IsOk());
    Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(take_, choice);
    EXPECT_THAT(take, IsOk());
    const Result<SceneFrame> scene = SceneLoader(**take, false).load(0);
    EXPECT_THAT(scene, IsOk());
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : scene->mesh.positions) box.extend(p);
    return box;
  };
  const Eigen::AlignedBox3f all = size_of({}), first = size_of(only("first")),
                            rest = size_of(without({"first"}));
  EXPECT_GT(all.sizes().x(), 2);
  EXPECT_LT(first.sizes().x(), 1.2);
  EXPECT_LT(rest.sizes().x(), 1.2);
  EXPECT_LT(first.max().x(), rest.min().x()) << "one stands on the left";
}

TEST_F(TwoApart, AreScoredOneByOne) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const Image there = *load_png(layout_.label_matte("cam03", "first", 1)), none(there.width, there.height, 1);
  ASSERT_THAT(save_png(none, layout_.label_matte("cam03", "first", 1)), IsOk());
  for (const char* label : {"first", "second"}) {
    const Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(take_, only(label));
    ASSERT_THAT(take, IsOk());
    const Result<std::vector<CameraMatteScores>> scores =
        evaluate_mattes(**take, layout_.truth().mattes(), {0, 1}, nullptr);
    ASSERT_THAT(scores, IsOk());
    ASSERT_EQ(scores->size(), 8U);
    for (const CameraMatteScores& camera : *scores) {
      EXPECT_EQ(camera.frames, 2);
      if (label == std::string("first") && camera.serial == "cam03")
        EXPECT_TRUE(camera.worst_iou == 0 && camera.worst_frame == 1) << "somebody took her away there";
      else
        EXPECT_GT(camera.worst_iou, 0.8) << label << ", " << camera.serial;
    }
  }
}

TEST_F(TwoApart, AreExportedOneByOne) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const LabelChoice choice = without({"first"});
  ASSERT_THAT(process_take({.take = take_, .frames = {0}, .threads = 2, .labels = choice}), IsOk());
  const fs::path out = folder_ / "colmap";
  ASSERT_THAT(export_colmap({.take = take_, .labels = choice, .out = out, .frames = {0}}), IsOk());
  const Image mask = *load_png(out / "masks/cam02.png.png"),
              theirs = *load_png(layout_.label_matte("cam02", "second", 0));
  long differ = 0, all = 0;
  for (std::size_t p = 0; p < mask.pixels.size(); ++p) {
    differ += (mask.pixels[p] >= 128) != (theirs.pixels[p] >= 128);
    all += theirs.pixels[p] >= 128;
  }
  EXPECT_GT(all, 50);
  EXPECT_LT(differ, all / 20) << "nobody else is in the mask";
}

TEST_F(TwoApart, HaveMeshesByAPlanAsWithoutOne) {
  ASSERT_THAT(say(both_clicked()), IsOk());
  const fs::path alone = folder_ / "alone";
  fs::copy(take_, alone, fs::copy_options::recursive);
  ProcessOptions options{.take = alone, .threads = 1, .labels = only("first")};
  ASSERT_THAT(process_take(options), IsOk());
  options.take = take_;
  Result<Plan> plan = plan_process(options, 1);
  ASSERT_THAT(plan, IsOk());
  plan->folder = folder_ / "plan";
  ASSERT_THAT(make_folder(plan->folder / "done"), IsOk());
  int meshes = 0;
  for (const PlanItem& item : plan->items) {
    ASSERT_THAT(run_process_item(*plan, item, options), IsOk()) << item.id;
    meshes += item.stage == "meshes";
  }
  EXPECT_EQ(meshes, 2);
  for (const int frame : {0, 1})
    EXPECT_EQ(*read_file(layout_.with_labels({"first"}).mesh(frame)),
              *read_file(TakeLayout(alone).with_labels({"first"}).mesh(frame)));
  EXPECT_FALSE(fs::exists(layout_.mesh(0))) << "nobody asked for all of them";
  EXPECT_THAT(find_subject(**open_chosen(take_, only("first"))), IsOk());
  EXPECT_THAT(find_subject(**open_chosen(take_, only("second"))),
              FailsWith(ErrorCode::NotFound, "--label second`"));
  const Result<ProcessReport> after = process_take(options);
  ASSERT_THAT(after, IsOk());
  EXPECT_EQ(after->meshes.made, 0);
  EXPECT_EQ(after->meshes.kept, 2) << "the take knows its meshes";
  options.labels = only("third");
  EXPECT_THAT(plan_process(options, 1), FailsWith(ErrorCode::NotFound, "has no label 'third'"));
}

// 100x75, one click of 1.5 px each: what an editor's brush draws in a view so small.
TEST_F(TwoApart, AreToldApartByClicksOfTheEditor) {
  ASSERT_THAT(save_matte_edits(strokes_of(both_clicked().clicks, 1.5), layout_.edits()), IsOk());
  const Result<LabelTakeReport> report = label_take(take_, {.threads = 2});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->labels, testing::ElementsAre("first", "second"));
  EXPECT_THAT(report->doubts, IsEmpty());
  EXPECT_EQ(report->made, 32);
  for (const char* label : {"first", "second"}) EXPECT_GE(iou_of(take_, label, 0, 2), 0.9) << label;
  EXPECT_EQ(label_take(take_, {.threads = 2})->kept, 32) << "nothing has changed";
}

// A click of one label in one frame says nothing of others, and the next one corrects what was carried: it
// takes the body that it is on, not both.
TEST_F(TwoApart, AreToldApartByClicksInFramesOfTheirOwn) {
  for (const auto& [first, second] : {std::pair(0, 1), std::pair(1, 0)}) {
    stroke_each(first, second);
    const Result<LabelTakeReport> report = label_take(take_, {.threads = 2});
    ASSERT_THAT(report, IsOk());
    EXPECT_THAT(report->doubts, IsEmpty());
    for (const char* label : {"first", "second"})
      EXPECT_GE(iou_of(take_, label, 0, 2), 0.9) << label << ", first clicked in frame " << first;
  }
}

TEST_F(TwoApart, KeepTheirLabelsWhenOneIsClickedOnceMore) {
  std::vector<LabelClick> clicks = both_clicked().clicks;
  ASSERT_THAT(say({{}, clicks}), IsOk());
  const double before = std::min(iou_of(take_, "first", 0, 2), iou_of(take_, "second", 0, 2));
  clicks.push_back(click_on(take_, "second", "cam05", 1));
  const Result<LabelTakeReport> report = say({{}, clicks});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, IsEmpty());
  for (const char* label : {"first", "second"}) EXPECT_GE(iou_of(take_, label, 0, 2), before - 0.01) << label;
}

TEST_F(TwoApart, KeepWhatColoursSayAgainstASingleClickAndSaySo) {
  std::vector<LabelClick> clicks = both_clicked().clicks;
  clicks.push_back(click_on(take_, "first", "cam03", 1));
  clicks.back().label = "second";
  const Result<LabelTakeReport> report = say({{}, clicks});
  ASSERT_THAT(report, IsOk());
  EXPECT_GE(iou_of(take_, "first", 1, 2), 0.9);
  ASSERT_EQ(report->doubts.size(), 1U);
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("camera 'cam03', frame 1"));
  EXPECT_THAT(sentence(report->doubts[0]),
              HasSubstr("what is said to be 'second' has the colours of another"));
}

// Two cameras of eight lack the second everywhere, so that no point of it is seen by all.
TEST_F(TwoApart, AreToldApartWithoutCamerasThatLackOneOfThemWhichAreNamed) {
  lose_the_second({"cam00", "cam04"}, {0, 1});
  for (const auto& [first, second] : {std::pair(0, 1), std::pair(1, 0), std::pair(0, 0)}) {
    const std::string which = text("clicked in frames ", first, " and ", second);
    stroke_each(first, second);
    const Result<LabelTakeReport> report = label_take(take_, {.threads = 2});
    ASSERT_THAT(report, IsOk());
    for (const char* label : {"first", "second"})
      EXPECT_GE(iou_in(take_, label, {"cam01", "cam02", "cam03", "cam05", "cam06", "cam07"}, 0, 2), 0.85)
          << label << ", " << which;
    ASSERT_EQ(report->doubts.size(), 2U) << which;
    for (const std::size_t i : {0U, 1U})
      EXPECT_THAT(sentence(report->doubts[i]),
                  HasSubstr(text("frame 0 (2 frames in all): the matte of 'cam0", 4 * i,
                                 "' has nobody where 'second' is said to be in frame ", second,
                                 " of camera 'cam03'")))
          << which;
  }
}

// The words are of a frame in which all is well.
TEST_F(TwoApart, KeepALabelThatOneCameraLosesInTheNextFrame) {
  lose_the_second({"cam00"}, {1});
  const Result<LabelTakeReport> report = say(both_clicked());
  ASSERT_THAT(report, IsOk());
  for (const char* label : {"first", "second"})
    EXPECT_GE(iou_in(take_, label, {"cam01", "cam02", "cam03", "cam04", "cam05", "cam06", "cam07"}, 1, 2),
              0.9)
        << label;
  ASSERT_EQ(report->doubts.size(), 1U);
  EXPECT_THAT(sentence(report->doubts[0]),
              HasSubstr("camera 'cam00', frame 1: the matte of 'cam00' has nobody"));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("where most others show 'second'"));
}

// Most cameras lack it: nobody can say where it is.
TEST_F(TwoApart, NameAClickThatTheMattesOfMostCamerasDeny) {
  lose_the_second({"cam00", "cam01", "cam04", "cam05", "cam06"}, {0, 1});
  LabelsSaid said = both_clicked();
  said.clicks[1] = click_on(take_, "second", "cam03", 1);
  const Result<LabelTakeReport> report = say(said);
  ASSERT_THAT(report, IsOk());
  ASSERT_THAT(report->doubts, testing::Not(IsEmpty()));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("camera 'cam03', frame 1"));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("'second'"));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("'cam00', 'cam01'"));
}

// The stroke's own pixels are more than what counts as nothing.
TEST_F(TwoApart, SayThatNothingIsLeftButALargeStroke) {
  lose_the_second({"cam00", "cam01", "cam04", "cam05", "cam06"}, {0, 1});
  ASSERT_THAT(
      save_matte_edits(
          strokes_of({click_on(take_, "first", "cam00", 0), click_on(take_, "second", "cam03", 0)}, 6),
          layout_.edits()),
      IsOk());
  const Result<LabelTakeReport> report = label_take(take_, {.threads = 2});
  ASSERT_THAT(report, IsOk());
  EXPECT_LT(iou_of(take_, "second", 0, 1), 0.5);
  const auto frames_of = [&](const char* what) {
    int frames = 0;
    for (const MatteDoubt& d : report->doubts)
      if (sentence(d).find(what) != std::string::npos) frames += d.frames;
    return frames;
  };
  EXPECT_EQ(frames_of("nothing is left of 'second'"), 2);
  EXPECT_EQ(frames_of("what is said to be 'second'"), 1);
}

TEST_F(TwoApart, NameAClickWhereSilhouettesBoundNothing) {
  for (int c = 0; c < 8; ++c)
    if (c != 3) {
      const fs::path file = layout_.matte(text("cam0", c), 1);
      const Image there = *load_png(file);
      ASSERT_THAT(save_png(Image(there.width, there.height, 1), file), IsOk());
    }
  LabelsSaid said = both_clicked();
  said.clicks.push_back(click_on(take_, "second", "cam03", 1));
  const Result<LabelTakeReport> report = say(said);
  ASSERT_THAT(report, IsOk());
  ASSERT_THAT(report->doubts, testing::Not(IsEmpty()));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("camera 'cam03', frame 1"));
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("'second'"));
}

TEST_F(TwoApart, NeedTheMattesOfWhatIsSaid) {
  LabelsSaid said = both_clicked();
  said.masks.push_back({"second", masks_of("second", "cam03", 1)});
  fs::remove(layout_.matte("cam03", 1));
  EXPECT_THAT(say(said), FailsWith(ErrorCode::NotFound, "camera 'cam03' has no matte of frame 1"));
}

TEST(LabelTake, SaysWhoIsLeftWithNothingWhereColoursDoNotTell) {
  const TempFolder folder;
  const fs::path take = take_of_two(folder, SyntheticCast::Alike, 2, 100);
  LabelTakeOptions options = clicks_of(take);
  options.said->clicks.push_back(click_on(take, "first", "cam03", 1));
  options.said->clicks.back().label = "second";
  const Result<LabelTakeReport> report = label_take(take, options);
  ASSERT_THAT(report, IsOk());
  EXPECT_LT(iou_of(take, "first", 1, 2), 0.1) << "as somebody said";
  ASSERT_EQ(report->doubts.size(), 1U);
  EXPECT_THAT(sentence(report->doubts[0]), HasSubstr("what was said of others took all of 'first'"));
}

// A part of one body that was carried as the other's.
TEST_F(TwoApart, GetBackAPartThatWasLost) {
  std::vector<LabelClick> clicks = both_clicked().clicks;
  const Image body = *load_png(layout_.truth().label_matte("cam02", "first", 0));
  Image upper(body.width, body.height, 1), lower = upper;
  int top = body.height, bottom = 0;
  for (int y = 0; y < body.height; ++y)
    for (int x = 0; x < body.width; ++x)
      if (*body.at(x, y) > 127) top = std::min(top, y), bottom = std::max(bottom, y);
  for (int y = 0; y < body.height; ++y)
    for (int x = 0; x < body.width; ++x) *(y < (top + bottom) / 2 ? upper : lower).at(x, y) = *body.at(x, y);
  // Somebody says wrongly that the legs of the first are the second, and rightly in the next frame that they
  // are not.
  const fs::path wrong = folder_ / "wrong/second/cam02/000000.png",
                 right = folder_ / "wrong/first/cam02/000000.png";
  fs::create_directories(wrong.parent_path());
  fs::create_directories(right.parent_path());
  const Image second = *load_png(layout_.truth().label_matte("cam02", "second", 0));
  for (std::size_t p = 0; p < lower.pixels.size(); ++p)
    lower.pixels[p] = std::max(lower.pixels[p], second.pixels[p]);
  ASSERT_THAT(save_png(lower, wrong), IsOk());
  ASSERT_THAT(save_png(upper, right), IsOk());
  LabelsSaid said{{{"first", folder_ / "wrong/first"}, {"second", folder_ / "wrong/second"}}, {}};
  ASSERT_THAT(say(said), IsOk());
  const double before = iou_of(take_, "first", 1, 2), other = iou_of(take_, "second", 1, 2);
  LabelClick legs{"first", "cam02", 1, 0, top + 0.8 * (bottom - top)};
  const Image next = *load_png(layout_.truth().label_matte("cam02", "first", 1));
  while (*next.at(static_cast<int>(legs.x), static_cast<int>(legs.y)) < 255) ++legs.x;
  legs.x += 1.5;
  said.clicks = {legs};
  const Result<LabelTakeReport> report = say(said);
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, IsEmpty());
  EXPECT_GE(iou_of(take_, "first", 1, 2), before + 0.2);
  EXPECT_GE(iou_of(take_, "second", 1, 2), other + 0.1) << "nothing else was taken from it";
}

TEST_F(TwoApart, HearClicksOfTheCommandLineAndStrokesTogether) {
  const std::vector<LabelClick> clicks = both_clicked().clicks;
  ASSERT_THAT(save_matte_edits(strokes_of({clicks[0]}, 1.5), layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}), FailsWith(ErrorCode::InvalidArgument, "'first' is the only label"));
  const Result<LabelTakeReport> report = say({{}, {clicks[1]}});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->labels, testing::ElementsAre("second", "first"));
  for (const char* label : {"first", "second"}) EXPECT_GE(iou_of(take_, label, 0, 2), 0.9) << label;
  EXPECT_EQ(load_label_record(layout_)->drawn, std::vector<std::string>{"first"});
}

TEST_F(TwoApart, AreNoLongerToldApartWhenTheLastStrokeIsGone) {
  ASSERT_THAT(save_matte_edits(strokes_of(both_clicked().clicks, 1.5), layout_.edits()), IsOk());
  ASSERT_THAT(label_take(take_, {}), IsOk());
  const fs::path theirs = layout_.label_matte("cam01", "first", 1),
                 ours = layout_.label_matte("cam02", "first", 1);
  ASSERT_THAT(save_png(*load_png(layout_.truth().label_matte("cam01", "first", 1)), theirs), IsOk());
  ASSERT_THAT(save_matte_edits({}, layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}), IsOkAnd(testing::Field(&LabelTakeReport::labels, IsEmpty())));
  EXPECT_FALSE(fs::exists(ours));
  EXPECT_FALSE(fs::exists(layout_.label_record()));
  EXPECT_TRUE(fs::exists(theirs)) << "somebody's";
}

TEST_F(TwoApart, NameStrokesThatMarkNobody) {
  MatteEdits edits = strokes_of(both_clicked().clicks, 1.5);
  MatteStroke& stroke = edits.cameras["cam00"].keyframes[0].strokes[1];
  stroke.points = {{2, 2}, {8, 2}};
  ASSERT_THAT(save_matte_edits(edits, layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}),
              FailsWith(ErrorCode::InvalidArgument,
                        "the stroke of 'second' at 2,2 in frame 0 of camera 'cam00' is on nobody"));
  stroke.points = {{500, 2}};
  ASSERT_THAT(save_matte_edits(edits, layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}), FailsWith(ErrorCode::InvalidArgument, "is outside the picture"));
  edits = strokes_of(both_clicked().clicks, 1.5);
  edits.cameras["cam00"].keyframes[0].frame = 7;
  ASSERT_THAT(save_matte_edits(edits, layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}), FailsWith(ErrorCode::InvalidArgument, "which the take does not have"));
  edits.cameras["cam00"].keyframes[0].frame = 0;
  fs::remove(layout_.matte("cam00", 0));
  ASSERT_THAT(save_matte_edits(edits, layout_.edits()), IsOk());
  EXPECT_THAT(label_take(take_, {}), FailsWith(ErrorCode::NotFound, "there is no matte"));
  EXPECT_FALSE(fs::exists(layout_.label_record())) << "nothing was kept of what was refused";
}

TEST_F(TwoApart, AreRefusedWithASentence) {
  const LabelsSaid good = both_clicked();
  EXPECT_THAT(label_take(take_, {}), IsOkAnd(testing::Field(&LabelTakeReport::labels, IsEmpty())));
  EXPECT_THAT(say({{}, {good.clicks[0]}}), FailsWith(ErrorCode::InvalidArgument, "everybody on stage"));
  LabelsSaid bad = good;
  bad.clicks[0].label = "../x";
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "cannot be a label"));
  bad = good;
  bad.clicks[0].x = 1, bad.clicks[0].y = 1;
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "is on nobody"));
  bad.clicks[0].x = 1000;
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "outside the picture"));
  bad = good;
  bad.clicks[0].serial = "cam99";
  EXPECT_THAT(say(bad), FailsWith(ErrorCode::InvalidArgument, "which the take does not have"));
  const fs::path masks = masks_of("first", "cam00", 0);
  ASSERT_THAT(save_png(Image(10, 10, 1), masks / "cam00/000000.png"), IsOk());
  EXPECT_THAT(say({{{"first", masks}}, {good.clicks[1]}}),
              FailsWith(ErrorCode::BadData, "the mask is 10x10"));
  EXPECT_THAT(say({{{"first", folder_ / "nowhere"}}, {good.clicks[1]}}),
              FailsWith(ErrorCode::NotFound, "is no folder"));
  EXPECT_FALSE(fs::exists(layout_.label_record())) << "nothing was kept of what was refused";
  ASSERT_THAT(say(good), IsOk());
  EXPECT_THAT(open_chosen(take_, only("third")),
              FailsWith(ErrorCode::NotFound, "has no label 'third'; it has first, second"));
  EXPECT_THAT(open_chosen(take_, without({"first", "second"})),
              FailsWith(ErrorCode::InvalidArgument, "nobody is left"));
}

TEST_F(TwoApart, LeaveAFolderOfUnknownOriginWhereItIs) {
  const fs::path theirs = layout_.label_masks() / "notes.txt";
  fs::create_directories(theirs.parent_path());
  ASSERT_THAT(write_file(theirs, "mine"), IsOk());
  EXPECT_THAT(say(both_clicked()), FailsWith(ErrorCode::AlreadyExists, "move it away"));
  EXPECT_TRUE(fs::exists(theirs));
  EXPECT_FALSE(fs::exists(layout_.label_record()));
}

}  // namespace
}  // namespace floatstage::pipeline
