#include "pipeline/matte/edited_camera.h"

#include <algorithm>

#include <unistd.h>

#include "core/file.h"
#include "core/matte.h"
#include "core/png.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/child_process.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kFrames = 6;
constexpr const char* kSerial = "cam01";

// A take, and others' mattes of it with two people: the truth, and a square that is nobody.
class Editing : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    small_take(*shared_, kFrames);
    fs::copy(TakeLayout(*shared_ / "take").truth().mattes(), *shared_ / "guide", fs::copy_options::recursive);
    for (int f = 0; f < kFrames; ++f) {
      const fs::path file = *shared_ / "guide" / kSerial / TakeLayout("").matte(kSerial, f).filename();
      Result<Image> matte = load_png(file);
      ASSERT_THAT(matte, IsOk());
      for (int y = 5; y < 25; ++y) std::fill_n(matte->at(4, y), 20, std::uint8_t{255});
      ASSERT_THAT(save_png(*matte, file), IsOk());
    }
  }
  static void TearDownTestSuite() { delete shared_; }

  Editing() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }

  EditedCameraOptions options(std::string method, bool guided = false) const {
    return {.take = take_,
            .serial = kSerial,
            .how = std::move(method),
            .guide = guided ? *shared_ / "guide" : fs::path(),
            .threads = 2};
  }
  std::unique_ptr<EditedCamera> open(const EditedCameraOptions& o) const {
    Result<std::unique_ptr<EditedCamera>> camera = EditedCamera::open(o);
    EXPECT_THAT(camera, IsOk());
    return camera ? std::move(*camera) : nullptr;
  }
  // As the editor does: the file first, then the mattes.
  Result<std::vector<int>> edit(EditedCamera& camera, const CameraEdits& edits,
                                const RemakeWatch& watch = {}) const {
    EXPECT_THAT(make_folder(TakeLayout(take_).mattes()), IsOk());
    EXPECT_THAT(save_matte_edits({{{kSerial, edits}}}, TakeLayout(take_).edits()), IsOk());
    return camera.remake(edits, watch);
  }
  static std::vector<Image> mattes_of(const fs::path& take) {
    std::vector<Image> all;
    for (int f = 0; f < kFrames; ++f) {
      Result<Image> matte = load_png(TakeLayout(take).matte(kSerial, f));
      all.push_back(matte ? std::move(*matte) : Image());
    }
    return all;
  }
  // What `floatstage matte` makes of mattes/edits.json in a take that has no mattes yet.
  std::vector<Image> replayed(const EditedCameraOptions& o) const {
    const fs::path copy = folder_ / "replay";
    fs::remove_all(copy);
    fs::copy(*shared_ / "take", copy, fs::copy_options::recursive);
    EXPECT_THAT(make_folder(TakeLayout(copy).mattes()), IsOk());
    fs::copy(TakeLayout(take_).edits(), TakeLayout(copy).edits());
    EXPECT_THAT(matte_take({.take = copy,
                            .how = o.how,
                            .guide = o.guide,
                            .cameras = {kSerial},
                            .threads = 2,
                            .hull_frames = 0}),
                IsOk());
    return mattes_of(copy);
  }
  // `floatstage matte` goes on where an editor stopped, without --redo.
  void continue_with_the_verb(const EditedCameraOptions& o) const {
    EXPECT_THAT(matte_take({.take = take_,
                            .how = o.how,
                            .guide = o.guide,
                            .cameras = {kSerial},
                            .threads = 2,
                            .hull_frames = 0}),
                IsOk());
  }

  static TempFolder* shared_;
  TempFolder folder_;
  fs::path take_ = folder_ / "edited";
};
TempFolder* Editing::shared_ = nullptr;

MatteStroke on_dancer(double x = 80) { return {MatteLabel::Foreground, 1, {{x, 60}}}; }
MatteStroke off_stranger() { return {MatteLabel::Background, 2, {{14, 15}}}; }
MatteMask garbage(int first, std::optional<int> last) {
  return {MatteLabel::Background, {{60, 20}, {100, 30}}, first, last, 8};
}

// A person's work, step by step: choosing, a mask, taking back, another keyframe before the first.
std::vector<CameraEdits> steps() {
  return {{},
          {{{2, {on_dancer(), off_stranger()}}}, {}},
          {{{2, {on_dancer(), off_stranger()}}}, {garbage(3, 4)}},
          {{{2, {on_dancer(), off_stranger()}}, {4, {{MatteLabel::Background, 6, {{80, 60}, {82, 90}}}}}},
           {garbage(3, 4)}},
          {{{1, {on_dancer()}},
            {2, {on_dancer(), off_stranger()}},
            {4, {{MatteLabel::Background, 6, {{80, 60}, {82, 90}}}}}},
           {garbage(3, {})}},
          {{{2, {on_dancer(), off_stranger()}}}, {}},
          {}};
}

class EditingBy : public Editing, public testing::WithParamInterface<std::string> {};

TEST_P(EditingBy, EveryStepMakesTheBytesThatTheVerbMakesFromTheFile) {
  const EditedCameraOptions o = options(GetParam(), GetParam() == "closed-form");
  const auto camera = open(o);
  ASSERT_TRUE(camera);
  int number = 0;
  for (const CameraEdits& edits : steps()) {
    SCOPED_TRACE(number++);
    ASSERT_THAT(edit(*camera, edits), IsOk());
    EXPECT_THAT(camera->failures(), IsEmpty());
    const std::vector<Image> mine = mattes_of(take_), theirs = replayed(o);
    for (int f = 0; f < kFrames; ++f) EXPECT_TRUE(!mine[f].empty() && mine[f] == theirs[f]) << "frame " << f;
  }
  EXPECT_THAT(camera->remake({}, {}), IsOkAnd(IsEmpty())) << "nothing is left to do";
}

INSTANTIATE_TEST_SUITE_P(Methods, EditingBy, testing::Values("auto", "chroma", "closed-form", "spectral"),
                         [](const auto& suite) {
                           std::string name = suite.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_F(Editing, MakesAgainOnlyWhatAMaskConcerns) {
  const auto camera = open(options("closed-form"));
  ASSERT_THAT(edit(*camera, {}), IsOkAnd(SizeIs(kFrames)));
  const auto time_of = [&](int f) { return fs::last_write_time(TakeLayout(take_).matte(kSerial, f)); };
  const auto before = time_of(1), last = time_of(5);
  EXPECT_THAT(edit(*camera, {{}, {garbage(3, 4)}}), IsOkAnd(testing::UnorderedElementsAre(3, 4)));
  EXPECT_EQ(time_of(1), before);
  EXPECT_EQ(time_of(5), last);
}

TEST_F(Editing, StopsFollowingWhereMattesComeOutAsTheyWere) {
  const EditedCameraOptions o = options("closed-form", true);
  const auto camera = open(o);
  const CameraEdits chosen{{{1, {on_dancer(), off_stranger()}}}, {}};
  ASSERT_THAT(edit(*camera, chosen), IsOk());
  CameraEdits more = chosen;
  more.keyframes.push_back(
      {3, {{MatteLabel::Background, 1, {{150, 110}}}}});  // says again what is so: nothing changes
  int visited = 0;
  RemakeWatch watch;
  watch.made = [&](int) { ++visited; };
  EXPECT_THAT(edit(*camera, more, watch), IsOkAnd(IsEmpty()));
  EXPECT_EQ(visited, 0);
  more.keyframes[1].strokes = {on_dancer(), {MatteLabel::Background, 3, {{80, 70}}}};
  const Result<std::vector<int>> changed = edit(*camera, more);
  ASSERT_THAT(changed, IsOk());
  EXPECT_THAT(*changed, testing::Contains(3));
  for (const int f : *changed) EXPECT_GE(f, 3) << "it goes on from its frame, away from the first keyframe";
}

long subject_pixels(const Image& matte) {
  return std::count_if(matte.pixels.begin(), matte.pixels.end(), [](int v) { return v >= 128; });
}

// A quarter of the dancer is missing in every matte; a click in the middle of it.
TEST_F(Editing, AClickWithAKeyBringsMoreThanItsPixelsHereAndInTheNeighbours) {
  const fs::path poor = folder_ / "poor";
  fs::copy(TakeLayout(*shared_ / "take").truth().mattes(), poor, fs::copy_options::recursive);
  for (int f = 0; f < kFrames; ++f) {
    const fs::path file = poor / kSerial / TakeLayout("").matte(kSerial, f).filename();
    Result<Image> matte = load_png(file);
    ASSERT_THAT(matte, IsOk());
    for (int y = 50; y < 75; ++y) std::fill_n(matte->at(0, y), matte->width, std::uint8_t{0});
    ASSERT_THAT(save_png(*matte, file), IsOk());
  }
  EditedCameraOptions o = options("given");
  o.guide = poor;
  const auto camera = open(o);
  ASSERT_THAT(edit(*camera, {}), IsOk());
  const std::vector<Image> before = mattes_of(take_);
  ASSERT_THAT(edit(*camera, {{{2, {on_dancer()}}}, {}}), IsOk());
  EXPECT_THAT(camera->idle(), IsEmpty());
  const std::vector<Image> after = mattes_of(take_);
  for (int f = 0; f < kFrames; ++f)
    EXPECT_GT(subject_pixels(after[f]), subject_pixels(before[f]) + 50) << "frame " << f;
}

TEST_F(Editing, AClickOnTheSubjectDropsNobodyAndOneOnTheOtherDropsHimInEveryFrame) {
  const auto camera = open(options("closed-form", true));
  ASSERT_THAT(edit(*camera, {}), IsOk());
  const std::vector<Image> before = mattes_of(take_);
  EXPECT_THAT(edit(*camera, {{{2, {on_dancer()}}}, {}}), IsOkAnd(IsEmpty()));
  ASSERT_THAT(edit(*camera, {{{2, {on_dancer(), off_stranger()}}}, {}}), IsOk());
  const std::vector<Image> after = mattes_of(take_);
  for (int f = 0; f < kFrames; ++f) {
    EXPECT_EQ(*after[f].at(14, 15), 0) << f;
    for (int y = 0; y < 120; ++y)
      for (int x = 40; x < 160; ++x) ASSERT_EQ(*after[f].at(x, y), *before[f].at(x, y)) << "frame " << f;
  }
}

TEST_F(Editing, ChangesSpectralMattesBetweenKeyframesOnly) {
  const auto camera = open(options("spectral"));
  const CameraEdits two{{{1, {on_dancer()}}, {4, {on_dancer()}}}, {}};
  ASSERT_THAT(edit(*camera, two), IsOk());
  CameraEdits three = two;
  three.keyframes.insert(three.keyframes.begin() + 1, {3, {{MatteLabel::Background, 6, {{80, 60}}}}});
  const Result<std::vector<int>> changed = edit(*camera, three);
  ASSERT_THAT(changed, IsOk());
  EXPECT_THAT(*changed, testing::Contains(3));
  for (int f : *changed) EXPECT_TRUE(f > 1 && f < 4) << f;
}

TEST_F(Editing, KnowsWhatIsStaleBeforeItIsMade) {
  const auto camera = open(options("closed-form"));
  EXPECT_EQ(camera->stale({}), std::vector<bool>(kFrames, true)) << "nothing has been made";
  ASSERT_THAT(edit(*camera, {}), IsOk());
  EXPECT_EQ(camera->stale({}), std::vector<bool>(kFrames, false));
  EXPECT_EQ(camera->stale({{}, {garbage(3, 4)}}),
            (std::vector<bool>{false, false, false, true, true, false}));
  fs::remove(TakeLayout(take_).matte(kSerial, 0));
  EXPECT_EQ(camera->stale({}), (std::vector<bool>{true, false, false, false, false, false}));
}

TEST_F(Editing, GoesOnInAnotherSessionWhereTheFirstEnded) {
  const CameraEdits edits{{{2, {on_dancer()}}}, {}};
  ASSERT_THAT(edit(*open(options("closed-form")), edits), IsOk());
  const auto again = open({.take = take_, .serial = kSerial, .how = ""});
  EXPECT_EQ(again->how(), "closed-form") << "as the mattes were made";
  EXPECT_EQ(again->edits(), edits);
  EXPECT_EQ(again->stale(edits), std::vector<bool>(kFrames, false));
}

class InterruptedEditing : public Editing, public testing::WithParamInterface<std::string> {};

TEST_P(InterruptedEditing, IsFinishedByTheVerbWithTheSameBytes) {
  const EditedCameraOptions o = options(GetParam());
  const CameraEdits edits{{{2, {on_dancer(), {MatteLabel::Background, 5, {{80, 80}}}}}}, {garbage(0, {})}};
  for (const int after : {0, 3}) {
    SCOPED_TRACE(after);
    fs::remove_all(TakeLayout(take_).mattes());
    const auto camera = open(o);
    ASSERT_THAT(edit(*camera, {}), IsOk());
    int made = 0;
    RemakeWatch watch;
    watch.made = [&](int) { ++made; };
    watch.stopped = [&] { return made > after; };
    EXPECT_THAT(edit(*camera, edits, watch), FailsWith(ErrorCode::Cancelled, "kept"));
    continue_with_the_verb(o);
    const std::vector<Image> mine = mattes_of(take_), theirs = replayed(o);
    for (int f = 0; f < kFrames; ++f) EXPECT_EQ(mine[f], theirs[f]) << "frame " << f;
  }
}

TEST_P(InterruptedEditing, OfAKilledProgramLeavesNothingHalfWritten) {
  const EditedCameraOptions o = options(GetParam());
  const CameraEdits edits{{{2, {on_dancer()}}}, {garbage(0, {})}};
  ASSERT_THAT(edit(*open(o), {}), IsOk());
  ChildProcess child([&](const std::function<void()>& report) {
    RemakeWatch watch;
    watch.made = [&](int) { report(); };
    return edit(*open(o), edits, watch) ? 0 : 1;
  });
  EXPECT_TRUE(child.wait_for_reports(2));
  child.kill();
  child.wait();
  for (const Image& matte : mattes_of(take_)) EXPECT_FALSE(matte.empty()) << "whole at any moment";
  EXPECT_THAT(load_matte_edits(TakeLayout(take_).edits()), IsOk());
  continue_with_the_verb(o);
  const std::vector<Image> mine = mattes_of(take_), theirs = replayed(o);
  for (int f = 0; f < kFrames; ++f) EXPECT_EQ(mine[f], theirs[f]) << "frame " << f;
}

INSTANTIATE_TEST_SUITE_P(Methods, InterruptedEditing, testing::Values("chroma", "spectral"),
                         [](const auto& suite) { return suite.param; });

TEST_F(Editing, TakesBackTheInterruptedStep) {
  const EditedCameraOptions o = options("closed-form");
  const auto camera = open(o);
  ASSERT_THAT(edit(*camera, {}), IsOk());
  const std::vector<Image> before = mattes_of(take_);
  RemakeWatch watch;
  int made = 0;
  watch.made = [&](int) { ++made; };
  watch.stopped = [&] { return made >= 2; };
  EXPECT_THAT(edit(*camera, {{}, {garbage(0, {})}}, watch), FailsWith(ErrorCode::Cancelled, ""));
  ASSERT_THAT(edit(*camera, {}), IsOk());
  EXPECT_EQ(mattes_of(take_), before);
}

TEST_F(Editing, LeavesOthersMattesAloneUnlessTold) {
  fs::copy(TakeLayout(take_).truth().mattes(), TakeLayout(take_).mattes(), fs::copy_options::recursive);
  const std::vector<Image> before = mattes_of(take_);
  EditedCameraOptions o = options("closed-form");
  EXPECT_THAT(edit(*open(o), {{}, {garbage(0, {})}}),
              FailsWith(ErrorCode::AlreadyExists, "not made by Floatstage"));
  EXPECT_EQ(mattes_of(take_), before);
  o.replace = true;
  EXPECT_THAT(edit(*open(o), {{}, {garbage(0, {})}}), IsOkAnd(SizeIs(kFrames)));
}

TEST_F(Editing, WorksOnATakeMadeByHandAndKeepsTheOriginals) {
  fs::copy(TakeLayout(take_).truth().mattes(), TakeLayout(take_).mattes(), fs::copy_options::recursive);
  const std::vector<Image> before = mattes_of(take_);
  const auto camera = open({.take = take_, .serial = kSerial, .threads = 2});
  EXPECT_EQ(camera->how(), "given");
  EXPECT_EQ(camera->stale({}), std::vector<bool>(kFrames, false)) << "nothing is asked for yet";
  EXPECT_THAT(edit(*camera, {}), IsOkAnd(IsEmpty()));
  EXPECT_FALSE(fs::exists(TakeLayout(take_).made_mattes())) << "nothing was made";
  EXPECT_THAT(edit(*camera, {{}, {garbage(3, 4)}}),
              FailsWith(ErrorCode::AlreadyExists, "2 mattes of camera 'cam01'"));
  EXPECT_EQ(mattes_of(take_), before);
  camera->allow_replacing();
  EXPECT_THAT(edit(*camera, {{}, {garbage(3, 4)}}), IsOkAnd(testing::UnorderedElementsAre(3, 4)));
  const std::vector<Image> after = mattes_of(take_);
  for (int f = 0; f < kFrames; ++f) {
    EXPECT_EQ(after[f] == before[f], f != 3 && f != 4) << f;
    EXPECT_THAT(load_png(TakeLayout(take_).given_mattes(kSerial) / TakeLayout("").matte("", f).filename()),
                IsOkAnd(before[f]));
  }
  EXPECT_EQ(*after[3].at(80, 110), *before[3].at(80, 110)) << "the given matte, but for the mask";
  // The verb says the same, and the next session needs not ask.
  EXPECT_THAT(matte_take({.take = take_, .cameras = {kSerial}, .redo = true, .hull_frames = 0}), IsOk());
  EXPECT_EQ(mattes_of(take_), after);
  EXPECT_THAT(edit(*open({.take = take_, .serial = kSerial}), {}), IsOkAnd(SizeIs(2)));
  EXPECT_EQ(mattes_of(take_), before) << "taken back";
}

TEST_F(Editing, GoesOnWithMattesThatAreConsistentAcrossCameras) {
  ASSERT_THAT(matte_take({.take = take_, .how = "consistent", .frames = {2}, .threads = 2, .hull_frames = 0}),
              IsOk());
  const auto camera = open({.take = take_, .serial = kSerial, .threads = 2});
  EXPECT_EQ(camera->how(), "consistent");
  const std::vector<bool> missing = camera->stale({});
  EXPECT_FALSE(missing[2]);
  const MatteMask mask{MatteLabel::Background, {{0, 0}, {160, 0}, {160, 120}, {0, 120}}, 2, 2};
  ASSERT_THAT(edit(*camera, {{}, {mask}}), IsOkAnd(SizeIs(kFrames)));
  EXPECT_EQ(mattes_of(take_)[2], Image(160, 120, 1)) << "all of it is garbage";
  EXPECT_GT(coverage(make_matte({}, mattes_of(take_)[3])), 0.02);
  EXPECT_THAT(edit(*camera, {}), IsOkAnd(ElementsAre(2))) << "taken back in its frame alone";
}

TEST_P(EditingBy, MakesNoMatteAgainWhenAStrokeIsNamed) {
  const EditedCameraOptions o = options(GetParam(), GetParam() == "closed-form");
  const auto camera = open(o);
  ASSERT_THAT(edit(*camera, {}), IsOk());
  CameraEdits edits{{{2, {on_dancer()}}}, {}};
  ASSERT_THAT(edit(*camera, edits), IsOk());
  const std::vector<Image> before = mattes_of(take_);
  edits.keyframes[0].strokes[0].subject = "dancer";
  EXPECT_THAT(edit(*camera, edits), IsOkAnd(IsEmpty()));
  continue_with_the_verb(o);
  EXPECT_EQ(mattes_of(take_), before);
  EXPECT_THAT(*read_file(TakeLayout(take_).made_mattes()), testing::Not(HasSubstr("subject")));
  const auto again = open(o);
  EXPECT_EQ(again->edits(), edits) << "the editor keeps the name";
  EXPECT_EQ(again->stale(edits), std::vector<bool>(kFrames, false));
  edits.keyframes[0].strokes.push_back(edits.keyframes[0].strokes[0]);
  ASSERT_THAT(edit(*camera, edits), IsOk());
  EXPECT_THAT(camera->idle(), IsEmpty()) << "it marks what is subject already, but says who it is";
}

TEST_P(EditingBy, KeepsTheMattesAndSaysSoWhenAStrokeChangesNothing) {
  const auto camera = open(options(GetParam(), GetParam() == "closed-form"));
  ASSERT_THAT(edit(*camera, {}), IsOk());
  const std::vector<Image> before = mattes_of(take_);
  const MatteStroke outside{MatteLabel::Background, 3, {{-90, -90}}},
      already{MatteLabel::Background, 1, {{150, 110}}};
  EXPECT_THAT(edit(*camera, {{{2, {outside, already}}}, {}}), IsOkAnd(IsEmpty()));
  EXPECT_THAT(camera->idle(),
              ElementsAre(testing::AllOf(HasSubstr("frame 2: stroke 1, background"), HasSubstr("outside")),
                          testing::AllOf(HasSubstr("frame 2: stroke 2"), HasSubstr("already"))));
  EXPECT_EQ(mattes_of(take_), before);
  ASSERT_THAT(edit(*camera, {}), IsOk());
  EXPECT_EQ(mattes_of(take_), before);
}

TEST_F(Editing, ShowsComponentsOfAFrameWhateverTheMethod) {
  const auto camera = open(options("chroma"));
  const Result<matting::MattingComponents> components = camera->components(3);
  ASSERT_THAT(components, IsOk());
  EXPECT_EQ(components->count(), 10);
  EXPECT_EQ(components->width, 160);
  EXPECT_FALSE(fs::exists(TakeLayout(take_).mattes())) << "looking leaves nothing in the take";
}

TEST_F(Editing, MetersTheFlickerOfAFrame) {
  const auto camera = open(options("chroma"));
  EXPECT_THAT(camera->flicker(1), IsOkAnd(std::optional<double>())) << "no mattes yet";
  ASSERT_THAT(edit(*camera, {}), IsOk());
  EXPECT_THAT(camera->flicker(0), IsOkAnd(std::optional<double>()));
  const Result<std::optional<double>> before = camera->flicker(3);
  ASSERT_THAT(before, IsOk());
  ASSERT_TRUE(before->has_value());
  EXPECT_LT(**before, 0.05);
  ASSERT_THAT(edit(*camera, {{}, {garbage(3, 3)}}), IsOk());
  EXPECT_GT(**camera->flicker(3), 1.5 * **before) << "the mask cuts a hole for one frame";
}

TEST_F(Editing, NamesWhatIsNotThere) {
  EXPECT_THAT(EditedCamera::open({.take = take_, .serial = "cam99"}),
              FailsWith(ErrorCode::InvalidArgument, "cam99"));
  EXPECT_THAT(EditedCamera::open({.take = take_, .serial = kSerial, .how = "magic"}),
              FailsWith(ErrorCode::InvalidArgument, "magic"));
  EXPECT_THAT(EditedCamera::open({.take = folder_ / "nowhere", .serial = kSerial}),
              FailsWith(ErrorCode::NotFound, "nowhere"));
  ASSERT_THAT(make_folder(TakeLayout(take_).mattes()), IsOk());
  ASSERT_THAT(write_file(TakeLayout(take_).edits(), "{\"floatstage_edits\": 1, \"cam"), IsOk());
  EXPECT_THAT(EditedCamera::open(options("chroma")), FailsWith(ErrorCode::BadData, "edits.json"));
}

TEST_F(Editing, KeepsTheMattesWhenTheDiskIsFull) {
  const EditedCameraOptions o = options("chroma");
  ASSERT_THAT(edit(*open(o), {}), IsOk());
  const CameraEdits edits{{}, {garbage(0, {})}};
  ASSERT_THAT(save_matte_edits({{{kSerial, edits}}}, TakeLayout(take_).edits()), IsOk());
  ChildProcess child([&](const std::function<void()>&) {
    const auto camera = open(o);
    let_files_grow_to(600);  // room for neither the record nor a matte
    const Result<std::vector<int>> made = camera->remake(edits, {});
    return !made && made.error().code == ErrorCode::Io ? 0 : 1;
  });
  EXPECT_EQ(child.wait(), 0);
  for (const Image& matte : mattes_of(take_)) EXPECT_FALSE(matte.empty());
  ASSERT_THAT(matte_take({.take = take_, .how = "chroma", .cameras = {kSerial}, .hull_frames = 0}), IsOk())
      << "room was made";
  EXPECT_EQ(mattes_of(take_), replayed(o));
}

}  // namespace
}  // namespace floatstage::pipeline
