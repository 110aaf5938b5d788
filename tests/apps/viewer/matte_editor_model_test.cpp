#include "apps/viewer/mattes/matte_editor_model.h"

#include <algorithm>
#include <functional>

#include <gmock/gmock.h>

#include "capture/sha256.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/child_process.h"
#include "tests/support/crossing_take.h"
#include "tests/support/small_take.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 5;
constexpr const char* kSerial = "cam01";

class AMatteEditorModel : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    small_take(*shared_, kFrames);
    ASSERT_THAT(pipeline::matte_take({.take = *shared_ / "take",
                                      .how = "chroma",
                                      .cameras = {kSerial},
                                      .threads = 2,
                                      .hull_frames = 0}),
                IsOk());
  }
  static void TearDownTestSuite() { delete shared_; }
  AMatteEditorModel() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }

  MatteEditorModelOptions options() {
    MatteEditorModelOptions o;
    o.camera = {.take = take_, .serial = kSerial, .threads = 1};
    o.say = [this](const std::string& line) { said_.push_back(line); };
    return o;
  }
  std::unique_ptr<MatteEditorModel> open() {
    Result<std::unique_ptr<MatteEditorModel>> model = MatteEditorModel::open(options());
    EXPECT_THAT(model, IsOk());
    if (!model) return nullptr;
    (*model)->state().fit.set_area(0, 0, 160, 120);  // window px are photograph px
    return std::move(*model);
  }
  static void send(MatteEditorModel& model, InputEvent::Kind kind, double x, double y, int button = 0) {
    InputEvent e;
    e.kind = kind, e.x = x, e.y = y, e.button = button;
    model.apply(take_input(e, model.state()));
  }
  static void draw(MatteEditorModel& model, const std::vector<std::pair<double, double>>& points,
                   int button = 0) {
    send(model, InputEvent::Kind::Press, points.front().first, points.front().second, button);
    for (const auto& [x, y] : points) send(model, InputEvent::Kind::Move, x, y);
    send(model, InputEvent::Kind::Release, points.back().first, points.back().second, button);
  }
  static void key(MatteEditorModel& model, int key, bool control = false) {
    InputEvent e;
    e.kind = InputEvent::Kind::Key, e.key = key, e.control = control;
    model.apply(take_input(e, model.state()));
  }
  static void settle(MatteEditorModel& model) {
    do {
      model.update(0);
      model.wait();
    } while (model.busy());
    model.update(0);
  }
  Image matte(int frame) const {
    Result<Image> m = load_png(TakeLayout(take_).matte(kSerial, frame));
    return m ? std::move(*m) : Image();
  }

  static TempFolder* shared_;
  TempFolder folder_;
  fs::path take_ = folder_ / "edited";
  std::vector<std::string> said_;
};
TempFolder* AMatteEditorModel::shared_ = nullptr;

TEST_F(AMatteEditorModel, WritesEveryEditAndMakesItsMattes) {
  const auto model = open();
  settle(*model);
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 0);
  key(*model, 'H');
  draw(*model, {{20, 60}, {30, 60}});
  const Result<MatteEdits> saved = load_matte_edits(TakeLayout(take_).edits());
  ASSERT_THAT(saved, IsOk()) << "before any matte is made";
  EXPECT_EQ(saved->cameras.at(kSerial), model->state().session.edits());
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, true));
  settle(*model);
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, false));
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 255);
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_THAT(said_[0], HasSubstr("5 mattes"));
  key(*model, 'Z', true);
  settle(*model);
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 0);
  EXPECT_THAT(load_matte_edits(TakeLayout(take_).edits()), IsOkAnd(MatteEdits()))
      << "nothing was said in the end";
}

TEST_F(AMatteEditorModel, WaitsForEnterWhenToldTo) {
  const auto model = open();
  settle(*model);
  key(*model, 'A');
  const Image before = matte(2);
  key(*model, 'G');
  draw(*model, {{80, 60}, {90, 60}});
  settle(*model);
  EXPECT_EQ(matte(2), before);
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, true)) << "but it is known";
  key(*model, kKeyEnter);
  settle(*model);
  EXPECT_NE(matte(2), before);
}

TEST_F(AMatteEditorModel, EndsAtTheLastOfManyQuickEdits) {
  const auto model = open();
  key(*model, 'H');
  for (int i = 0; i < 6; ++i) {
    draw(*model, {{10.0 + 20 * i, 20}});
    model->update(0);
  }
  settle(*model);
  const Image last = matte(4);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(*last.at(10 + 20 * i, 20), 255) << i;
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, false));
}

TEST_F(AMatteEditorModel, ShowsTheViewOfTheFrame) {
  const auto model = open();
  settle(*model);
  key(*model, '4');
  settle(*model);
  const Image shown = model->picture(), alpha = matte(0);
  for (std::size_t p = 0; p < alpha.pixels.size(); p += 37) EXPECT_EQ(shown.pixels[3 * p], alpha.pixels[p]);
  const int number = model->picture_number();
  settle(*model);
  EXPECT_EQ(model->picture_number(), number) << "the same picture is not made again";
  key(*model, kKeyRight);
  settle(*model);
  EXPECT_GT(model->picture_number(), number);
  key(*model, '6');
  settle(*model);
  EXPECT_TRUE(model->has_matte());
  const Image components = model->picture();
  key(*model, '1');
  settle(*model);
  EXPECT_NE(components, model->picture());
}

TEST_F(AMatteEditorModel, MetersTheClipAndJumpsToItsWorstFrame) {
  const auto model = open();
  key(*model, 'G');
  model->state().session.mask_reach = MaskReach::ThisFrame;
  model->state().session.radius = 25;
  model->state().time.seek(2);
  draw(*model, {{80, 40}, {80, 90}});
  settle(*model);
  for (int f = 1; f < kFrames; ++f) EXPECT_TRUE(model->state().flicker[static_cast<std::size_t>(f)]) << f;
  model->state().time.seek(0);
  key(*model, 'W');
  EXPECT_TRUE(model->state().time.frame() == 2 || model->state().time.frame() == 3)
      << "where the dancer is cut off, or back again";
}

TEST_F(AMatteEditorModel, KeepsWhatWasSaidOfOtherCameras) {
  CameraEdits other;
  other.masks.push_back({MatteLabel::Background, {{0, 0}}, 0, {}, 5});
  ASSERT_THAT(save_matte_edits({{{"cam04", other}}}, TakeLayout(take_).edits()), IsOk());
  const auto model = open();
  draw(*model, {{80, 60}});
  const Result<MatteEdits> saved = load_matte_edits(TakeLayout(take_).edits());
  ASSERT_THAT(saved, IsOk());
  EXPECT_EQ(saved->cameras.at("cam04"), other);
  EXPECT_EQ(saved->cameras.size(), 2u);
  settle(*model);
}

TEST_F(AMatteEditorModel, OffersTheTakesLabelsAndWritesWhoseAStrokeIs) {
  MatteEdits edits;
  edits.cameras["cam02"].keyframes.push_back({1, {{MatteLabel::Foreground, 3, {{20, 20}}, "woman"}}});
  fs::create_directories(TakeLayout(take_).mattes());
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take_).edits()), IsOk());
  pipeline::LabelRecord record;
  record.labels = {"man"};
  ASSERT_THAT(pipeline::save_label_record(record, TakeLayout(take_)), IsOk());
  const auto model = open();
  EXPECT_EQ(model->state().labels, (std::vector<std::string>{"man", "woman"}));
  EXPECT_EQ(model->state().session.subject, "");
  key(*model, 'L');
  draw(*model, {{80, 60}});
  const Result<MatteEdits> written = load_matte_edits(TakeLayout(take_).edits());
  ASSERT_THAT(written, IsOk());
  EXPECT_EQ(written->cameras.at(kSerial).keyframes.at(0).strokes.at(0).subject, "man");
  EXPECT_EQ(written->cameras.at("cam02"), edits.cameras.at("cam02"));
  settle(*model);
  MatteEditorModelOptions again = options();  // as another camera is opened in the same window
  again.subject = "child", again.labels = {"man", "child"};
  const Result<std::unique_ptr<MatteEditorModel>> other = MatteEditorModel::open(again);
  ASSERT_THAT(other, IsOk());
  EXPECT_EQ((*other)->state().labels, (std::vector<std::string>{"man", "woman", "child"}));
  EXPECT_EQ((*other)->state().session.subject, "child");
}

// Somebody has given the left half of what there is to "left", and the rest to "right".
TEST_F(AMatteEditorModel, ShowsTheDivisionAmongLabelsAndSaysWhenItIsOlderThanTheMatte) {
  const TakeLayout layout(take_);
  const Image all = matte(0);
  Image left = all, right = all;
  for (int y = 0; y < all.height; ++y)
    for (int x = 0; x < all.width; ++x) *(x < all.width / 2 ? right : left).at(x, y) = 0;
  pipeline::LabelRecord record;
  record.labels = {"left", "right"};
  record.sums[kSerial][0] = capture::sha256(*read_file(layout.matte(kSerial, 0)));
  ASSERT_THAT(pipeline::save_label_record(record, layout), IsOk());
  for (const auto& [label, image] : {std::pair("left", &left), std::pair("right", &right)}) {
    ASSERT_THAT(make_folder(layout.label_matte(kSerial, label, 0).parent_path()), IsOk());
    ASSERT_THAT(save_png(*image, layout.label_matte(kSerial, label, 0)), IsOk());
  }
  const auto model = open();
  settle(*model);
  model->state().status = "";
  key(*model, '7');
  settle(*model);
  EXPECT_EQ(model->state().status, "");
  const Image shown = model->picture();
  for (std::size_t p = 0; p < all.pixels.size(); ++p) {
    if (all.pixels[p] < 255) continue;
    const std::uint8_t* rgb = shown.pixels.data() + 3 * p;
    const auto color = component_color(left.pixels[p] ? 0 : 1);
    const auto strongest = [](const auto* c) { return std::max_element(c, c + 3) - c; };
    ASSERT_EQ(strongest(rgb), strongest(color.data())) << p;
  }
  key(*model, 'G');
  draw(*model, {{80, 60}, {90, 60}});
  settle(*model);
  EXPECT_THAT(model->state().status, HasSubstr("the labels are older than this matte"));
  key(*model, kKeyRight);
  settle(*model);
  EXPECT_THAT(model->state().status, HasSubstr("no labels of this frame"));
}

TEST_F(AMatteEditorModel, SaysThatADamagedFileIsNotOverwritten) {
  const auto model = open();
  settle(*model);
  ASSERT_THAT(write_file(TakeLayout(take_).edits(), "{\"floatstage_ed"), IsOk());
  const Image before = matte(0);
  draw(*model, {{80, 60}});
  EXPECT_THAT(model->state().status, HasSubstr("not saved"));
  EXPECT_THAT(model->state().status, HasSubstr("edits.json"));
  settle(*model);
  EXPECT_EQ(matte(0), before);
  EXPECT_THAT(read_file(TakeLayout(take_).edits()), IsOkAnd(std::string("{\"floatstage_ed")));
  EXPECT_THAT(MatteEditorModel::open(options()), FailsWith(ErrorCode::BadData, "edits.json"));
}

TEST_F(AMatteEditorModel, SaysThatATakeCannotBeWritten) {
  ChildProcess child([&](const std::function<void()>&) {
    let_files_grow_to(0);
    const auto model = MatteEditorModel::open(options());
    if (!model) return 1;
    (*model)->state().fit.set_area(0, 0, 160, 120);
    draw(**model, {{80, 60}});
    const std::string status = (*model)->state().status;
    settle(**model);
    return status.find("not saved") != std::string::npos && status.find("edits.json") != std::string::npos &&
                   !(*model)->remaking()
               ? 0
               : 2;
  });
  EXPECT_EQ(child.wait(), 0);
  EXPECT_FALSE(fs::exists(TakeLayout(take_).edits()));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(take_))
    EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".tmp")));
}

TEST_F(AMatteEditorModel, MayBeClosedInTheMiddle) {
  for (int frames_first = 0; frames_first < 3; ++frames_first) {
    const auto model = open();
    key(*model, 'H');
    draw(*model, {{20.0 + frames_first, 60}});
    for (int i = 0; i <= frames_first; ++i) model->update(0);
  }  // closed here, while mattes are being made
  for (int f = 0; f < kFrames; ++f) EXPECT_FALSE(matte(f).empty());
  ASSERT_THAT(pipeline::matte_take({.take = take_,
                                    .how = "chroma",
                                    .cameras = {kSerial},
                                    .threads = 1,
                                    .redo = true,
                                    .hull_frames = 0}),
              IsOk());
  for (int f = 0; f < kFrames; ++f) EXPECT_EQ(*matte(f).at(22, 60), 255);
}

TEST_F(AMatteEditorModel, AsksBeforeItChangesMattesThatSomebodyElseMade) {
  fs::remove_all(TakeLayout(take_).mattes());
  fs::copy(TakeLayout(take_).truth().mattes(), TakeLayout(take_).mattes(), fs::copy_options::recursive);
  const Image before = matte(2);
  const auto model = open();
  settle(*model);
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, false));
  key(*model, 'H');
  draw(*model, {{20, 60}, {30, 60}});
  settle(*model);
  EXPECT_THAT(model->state().question, HasSubstr("5 mattes of camera 'cam01'"));
  draw(*model, {{50, 60}});  // nothing is drawn before there is an answer
  EXPECT_EQ(model->state().session.edits().masks.size(), 1u);
  key(*model, 'N');
  settle(*model);
  EXPECT_EQ(model->state().question, "");
  EXPECT_EQ(model->state().session.edits(), CameraEdits()) << "taken back";
  EXPECT_EQ(matte(2), before);

  draw(*model, {{20, 60}, {30, 60}});
  settle(*model);
  key(*model, 'Y');
  settle(*model);
  EXPECT_EQ(model->state().stale, std::vector<bool>(kFrames, false));
  EXPECT_EQ(*matte(2).at(25, 60), 255);
  EXPECT_THAT(load_png(TakeLayout(take_).given_mattes(kSerial) / "000002.png"), IsOkAnd(before));
  draw(*model, {{50, 60}});
  settle(*model);
  EXPECT_EQ(*matte(2).at(50, 60), 255) << "once is enough";
}

TEST_F(AMatteEditorModel, NamesWhatIsNotThere) {
  MatteEditorModelOptions o = options();
  o.frame = 99;
  EXPECT_THAT(MatteEditorModel::open(o), FailsWith(ErrorCode::InvalidArgument, "frame 99"));
  o.camera.serial = "cam77";
  EXPECT_THAT(MatteEditorModel::open(o), FailsWith(ErrorCode::InvalidArgument, "cam77"));
}

// Two performers cross; one was marked as background while he stood clear.
TEST(AMatteEditorModelAtACrossing, SaysWhereAStrokeIsFollowedNoFurtherAndShowsItsReach) {
  const TempFolder folder;
  const fs::path take = crossing_take(folder);
  std::vector<std::string> said;
  MatteEditorModelOptions options;
  options.camera = {.take = take,
                    .serial = "cam00",
                    .how = "given",
                    .guide = TakeLayout(take).truth().mattes(),
                    .threads = 1};
  options.say = [&](const std::string& line) { said.push_back(line); };
  const Result<std::unique_ptr<MatteEditorModel>> model = MatteEditorModel::open(options);
  ASSERT_THAT(model, IsOk());
  EditorState& state = (*model)->state();
  state.session.radius = off_the_second().radius;
  const auto points = off_the_second().points;
  state.session.press(0, points.front(), true);
  for (const Eigen::Vector2d& p : points) state.session.drag(p);
  ASSERT_TRUE(state.session.release());
  (*model)->apply({.edited = true});
  do {
    (*model)->update(0);
    (*model)->wait();
  } while ((*model)->busy());
  (*model)->update(0);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.back(), HasSubstr("background is followed no further than frame 1"))
      << "in the window's line";
  EXPECT_TRUE(state.guided[0] && state.guided[9]);
  EXPECT_FALSE(state.guided.back()) << "the reach ends with the carry";
  ASSERT_FALSE(state.doubts.empty());
  EXPECT_GE(state.doubts.begin()->first, 10);
}

}  // namespace
}  // namespace floatstage::apps
