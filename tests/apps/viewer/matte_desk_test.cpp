#include "apps/viewer/mattes/matte_desk.h"

#include <functional>

#include <gmock/gmock.h>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/matte/matte_take.h"
#include "tests/support/child_process.h"
#include "tests/support/small_take.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 5;
constexpr const char* kSerial = "cam01";

class AMatteDesk : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    small_take(*shared_, kFrames);
    ASSERT_THAT(matte_take({.take = *shared_ / "take",
                            .method = "chroma",
                            .cameras = {kSerial},
                            .threads = 2,
                            .hull_frames = 0}),
                IsOk());
  }
  static void TearDownTestSuite() { delete shared_; }
  AMatteDesk() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }

  MatteDeskOptions options() {
    MatteDeskOptions o;
    o.camera = {.take = take_, .serial = kSerial, .threads = 1};
    o.say = [this](const std::string& line) { said_.push_back(line); };
    return o;
  }
  std::unique_ptr<MatteDesk> open() {
    Result<std::unique_ptr<MatteDesk>> desk = MatteDesk::open(options());
    EXPECT_THAT(desk, IsOk());
    if (!desk) return nullptr;
    (*desk)->state().fit.set_area(0, 0, 160, 120);  // window px are photograph px
    return std::move(*desk);
  }
  static void send(MatteDesk& desk, InputEvent::Kind kind, double x, double y, int button = 0) {
    InputEvent e;
    e.kind = kind, e.x = x, e.y = y, e.button = button;
    desk.obey(take_input(e, desk.state()));
  }
  static void draw(MatteDesk& desk, const std::vector<std::pair<double, double>>& points, int button = 0) {
    send(desk, InputEvent::Kind::Press, points.front().first, points.front().second, button);
    for (const auto& [x, y] : points) send(desk, InputEvent::Kind::Move, x, y);
    send(desk, InputEvent::Kind::Release, points.back().first, points.back().second, button);
  }
  static void key(MatteDesk& desk, int key, bool control = false) {
    InputEvent e;
    e.kind = InputEvent::Kind::Key, e.key = key, e.control = control;
    desk.obey(take_input(e, desk.state()));
  }
  static void settle(MatteDesk& desk) {
    do {
      desk.update(0);
      desk.wait();
    } while (desk.busy());
    desk.update(0);
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
TempFolder* AMatteDesk::shared_ = nullptr;

TEST_F(AMatteDesk, WritesEveryEditAndMakesItsMattes) {
  const auto desk = open();
  settle(*desk);
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 0);
  key(*desk, 'H');
  draw(*desk, {{20, 60}, {30, 60}});
  const Result<MatteEdits> saved = load_matte_edits(TakeLayout(take_).edits());
  ASSERT_THAT(saved, IsOk()) << "before any matte is made";
  EXPECT_EQ(saved->cameras.at(kSerial), desk->state().session.edits());
  EXPECT_EQ(desk->state().stale, std::vector<bool>(kFrames, true));
  settle(*desk);
  EXPECT_EQ(desk->state().stale, std::vector<bool>(kFrames, false));
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 255);
  ASSERT_EQ(said_.size(), 1u);
  EXPECT_THAT(said_[0], HasSubstr("5 mattes"));
  key(*desk, 'Z', true);
  settle(*desk);
  EXPECT_EQ(matte(0).pixels[static_cast<std::size_t>(60 * 160 + 20)], 0);
  EXPECT_THAT(load_matte_edits(TakeLayout(take_).edits()), IsOkAnd(MatteEdits()))
      << "nothing was said in the end";
}

TEST_F(AMatteDesk, WaitsForEnterWhenToldTo) {
  const auto desk = open();
  settle(*desk);
  key(*desk, 'A');
  const Image before = matte(2);
  key(*desk, 'G');
  draw(*desk, {{80, 60}, {90, 60}});
  settle(*desk);
  EXPECT_EQ(matte(2), before);
  EXPECT_EQ(desk->state().stale, std::vector<bool>(kFrames, true)) << "but it is known";
  key(*desk, kKeyEnter);
  settle(*desk);
  EXPECT_NE(matte(2), before);
}

TEST_F(AMatteDesk, EndsAtTheLastOfManyQuickEdits) {
  const auto desk = open();
  key(*desk, 'H');
  for (int i = 0; i < 6; ++i) {
    draw(*desk, {{10.0 + 20 * i, 20}});
    desk->update(0);
  }
  settle(*desk);
  const Image last = matte(4);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(*last.at(10 + 20 * i, 20), 255) << i;
  EXPECT_EQ(desk->state().stale, std::vector<bool>(kFrames, false));
}

TEST_F(AMatteDesk, ShowsTheViewOfTheFrame) {
  const auto desk = open();
  settle(*desk);
  key(*desk, '4');
  settle(*desk);
  const Image shown = desk->picture(), alpha = matte(0);
  for (std::size_t p = 0; p < alpha.pixels.size(); p += 37) EXPECT_EQ(shown.pixels[3 * p], alpha.pixels[p]);
  const int number = desk->picture_number();
  settle(*desk);
  EXPECT_EQ(desk->picture_number(), number) << "the same picture is not made again";
  key(*desk, kKeyRight);
  settle(*desk);
  EXPECT_GT(desk->picture_number(), number);
  key(*desk, '6');
  settle(*desk);
  EXPECT_TRUE(desk->has_matte());
  const Image components = desk->picture();
  key(*desk, '1');
  settle(*desk);
  EXPECT_NE(components, desk->picture());
}

TEST_F(AMatteDesk, MetersTheClipAndJumpsToItsWorstFrame) {
  const auto desk = open();
  key(*desk, 'G');
  desk->state().session.mask_reach = MaskReach::ThisFrame;
  desk->state().session.radius = 25;
  desk->state().time.seek(2);
  draw(*desk, {{80, 40}, {80, 90}});
  settle(*desk);
  for (int f = 1; f < kFrames; ++f) EXPECT_TRUE(desk->state().flicker[static_cast<std::size_t>(f)]) << f;
  desk->state().time.seek(0);
  key(*desk, 'W');
  EXPECT_TRUE(desk->state().time.frame() == 2 || desk->state().time.frame() == 3)
      << "where the dancer is cut off, or back again";
}

TEST_F(AMatteDesk, KeepsWhatWasSaidOfOtherCameras) {
  CameraEdits other;
  other.masks.push_back({MatteLabel::Background, {{0, 0}}, 0, {}, 5});
  ASSERT_THAT(save_matte_edits({{{"cam04", other}}}, TakeLayout(take_).edits()), IsOk());
  const auto desk = open();
  draw(*desk, {{80, 60}});
  const Result<MatteEdits> saved = load_matte_edits(TakeLayout(take_).edits());
  ASSERT_THAT(saved, IsOk());
  EXPECT_EQ(saved->cameras.at("cam04"), other);
  EXPECT_EQ(saved->cameras.size(), 2u);
  settle(*desk);
}

TEST_F(AMatteDesk, SaysThatADamagedFileIsNotOverwritten) {
  const auto desk = open();
  settle(*desk);
  ASSERT_THAT(write_file(TakeLayout(take_).edits(), "{\"floatstage_ed"), IsOk());
  const Image before = matte(0);
  draw(*desk, {{80, 60}});
  EXPECT_THAT(desk->state().status, HasSubstr("not saved"));
  EXPECT_THAT(desk->state().status, HasSubstr("edits.json"));
  settle(*desk);
  EXPECT_EQ(matte(0), before);
  EXPECT_THAT(read_file(TakeLayout(take_).edits()), IsOkAnd(std::string("{\"floatstage_ed")));
  EXPECT_THAT(MatteDesk::open(options()), FailsWith(ErrorCode::BadData, "edits.json"));
}

TEST_F(AMatteDesk, SaysThatATakeCannotBeWritten) {
  ChildProcess child([&](const std::function<void()>&) {
    let_files_grow_to(0);
    const auto desk = MatteDesk::open(options());
    if (!desk) return 1;
    (*desk)->state().fit.set_area(0, 0, 160, 120);
    draw(**desk, {{80, 60}});
    const std::string status = (*desk)->state().status;
    settle(**desk);
    return status.find("not saved") != std::string::npos && status.find("edits.json") != std::string::npos &&
                   !(*desk)->remaking()
               ? 0
               : 2;
  });
  EXPECT_EQ(child.wait(), 0);
  EXPECT_FALSE(fs::exists(TakeLayout(take_).edits()));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(take_))
    EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".tmp")));
}

TEST_F(AMatteDesk, MayBeClosedInTheMiddle) {
  for (int frames_first = 0; frames_first < 3; ++frames_first) {
    const auto desk = open();
    key(*desk, 'H');
    draw(*desk, {{20.0 + frames_first, 60}});
    for (int i = 0; i <= frames_first; ++i) desk->update(0);
  }  // closed here, while mattes are being made
  for (int f = 0; f < kFrames; ++f) EXPECT_FALSE(matte(f).empty());
  ASSERT_THAT(matte_take({.take = take_,
                          .method = "chroma",
                          .cameras = {kSerial},
                          .threads = 1,
                          .redo = true,
                          .hull_frames = 0}),
              IsOk());
  for (int f = 0; f < kFrames; ++f) EXPECT_EQ(*matte(f).at(22, 60), 255);
}

TEST_F(AMatteDesk, NamesWhatIsNotThere) {
  MatteDeskOptions o = options();
  o.frame = 99;
  EXPECT_THAT(MatteDesk::open(o), FailsWith(ErrorCode::InvalidArgument, "frame 99"));
  o.camera.serial = "cam77";
  EXPECT_THAT(MatteDesk::open(o), FailsWith(ErrorCode::InvalidArgument, "cam77"));
}

}  // namespace
}  // namespace floatstage::apps
