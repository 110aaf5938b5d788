#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>

#include "core/matte_edits.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "tests/support/run_command.h"
#include "tests/support/small_take.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kFrames = 6;
constexpr const char* kSerial = "cam01";

// The real window under a virtual display, worked by xdotool as by a hand.
class MatteEditorUnderXvfb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    small_take(*shared_, kFrames);
  }
  static void TearDownTestSuite() { delete shared_; }
  MatteEditorUnderXvfb() { fs::copy(*shared_ / "take", take_, fs::copy_options::recursive); }

  // `hands` is bash: it may say `x <xdotool's words>`, `at <x> <y>` (photograph px), `said <words>` (waits
  // until the editor has said a line with them), and must end the editor, by a key or otherwise. Returns the
  // editor's exit code.
  int edit(const std::string& arguments, const std::string& hands) {
    const fs::path script =
        folder_.write("hands.sh", text(R"(
cd ')",
                                       folder_.path().string(), R"('
coproc EDITOR { exec )",
                                       FLOATSTAGE_PROGRAM, " play '", take_.string(), "' --mattes --camera ",
                                       kSerial, " --size 900x620 ", arguments, R"( 2>&1; }
editor=$EDITOR_PID
exec 3<&"${EDITOR[0]}"
said() { while read -r -t 120 -u 3 line; do echo "$line"; case "$line" in *"$1"*) return 0;; esac; done; echo "never said: $1"; kill $editor; exit 99; }
x() { xdotool "$@"; }
# Two moves that the X server has not handed out yet become one, so each is waited for.
# The canvas is 630x528 at (270, 0); a photograph of 160x120 stands in it 3.9375 times as large, with bars above and below.
at() { xdotool mousemove --sync --window $window $(awk "BEGIN { printf \"%d %d\", 270 + $1 * 3.9375, 27.75 + $2 * 3.9375 }"); }
said 'matte editor is open'
window=$(xdotool search --sync --onlyvisible --name Floatstage | head -1)
x windowmove --sync $window 0 0 2>/dev/null
x windowfocus --sync $window
)",
                                       hands, R"(
cat <&3
wait $editor
exit $?
)"));
    Ended ended = run_command(under_display("bash " + script.string()));
    output_ = std::move(ended.output);
    return ended.code;
  }
  std::vector<Image> mattes_of(const fs::path& take) const {
    std::vector<Image> all;
    for (int f = 0; f < kFrames; ++f) {
      Result<Image> matte = load_png(TakeLayout(take).matte(kSerial, f));
      all.push_back(matte ? std::move(*matte) : Image());
    }
    return all;
  }
  // What the verb makes of the take and mattes/edits.json alone.
  std::vector<Image> replayed(const std::string& method) const {
    const fs::path copy = folder_ / "replay";
    fs::copy(*shared_ / "take", copy, fs::copy_options::recursive);
    fs::create_directory(TakeLayout(copy).mattes());
    fs::copy(TakeLayout(take_).edits(), TakeLayout(copy).edits());
    EXPECT_EQ(run_matte(copy, "--matte " + method), 0);
    return mattes_of(copy);
  }
  static int run_matte(const fs::path& take, const std::string& arguments) {
    return WEXITSTATUS(std::system(text(FLOATSTAGE_PROGRAM, " matte '", take.string(), "' --cameras ",
                                        kSerial, " --hull-frames 0 ", arguments, " > /dev/null")
                                       .c_str()));
  }
  CameraEdits edits() const {
    Result<MatteEdits> all = load_matte_edits(TakeLayout(take_).edits());
    EXPECT_THAT(all, IsOk());
    return all ? all->cameras[kSerial] : CameraEdits();
  }

  static TempFolder* shared_;
  TempFolder folder_;
  fs::path take_ = folder_ / "take";
  std::string output_;
};
TempFolder* MatteEditorUnderXvfb::shared_ = nullptr;

void expect_near(const Eigen::Vector2d& p, double x, double y) {
  EXPECT_LT((p - Eigen::Vector2d(x, y)).norm(), 0.6) << p.transpose();
}

TEST_F(MatteEditorUnderXvfb, TurnsWhatHandsDoIntoAFileThatTheVerbReplaysBitByBit) {
  ASSERT_EQ(edit("--matte closed-form --frame 2 --by-hand", R"(
at 80 60;  x click 1                                     # the dancer is subject
at 14 15;  x mousedown 3; at 30 15; at 30 30; x mouseup 3   # the corner is not
x key g;   at 20 100; x mousedown 1; at 50 100; x mouseup 1  # garbage
x key h;   at 140 20; x click 1                          # a hold-out …
x key ctrl+z                                             # … which was a mistake,
x key ctrl+shift+z ctrl+z                                # really
x key f Right Right; at 82 64; x click 1                 # another keyframe
x key comma Delete ctrl+z                                # back to the first, which goes and comes back
x key Return
said 'mattes changed'
x key 4 F12
said 'screenshot'
x key ctrl+q
)"),
            0)
      << output_;
  const CameraEdits made = edits();
  ASSERT_EQ(made.keyframes.size(), 2u) << output_;
  EXPECT_EQ(made.keyframes[0].frame, 2);
  EXPECT_EQ(made.keyframes[1].frame, 4);
  ASSERT_EQ(made.keyframes[0].strokes.size(), 2u);
  EXPECT_EQ(made.keyframes[0].strokes[0].label, MatteLabel::Foreground);
  ASSERT_EQ(made.keyframes[0].strokes[0].points.size(), 1u) << "a click";
  expect_near(made.keyframes[0].strokes[0].points[0], 80, 60);
  EXPECT_EQ(made.keyframes[0].strokes[1].label, MatteLabel::Background);
  ASSERT_EQ(made.keyframes[0].strokes[1].points.size(), 3u) << "a scribble";
  expect_near(made.keyframes[0].strokes[1].points[2], 30, 30);
  expect_near(made.keyframes[1].strokes[0].points[0], 82, 64);
  ASSERT_EQ(made.masks.size(), 1u) << "the hold-out was taken back";
  EXPECT_EQ(made.masks[0].label, MatteLabel::Background);
  EXPECT_GT(made.masks[0].radius, 0);
  expect_near(made.masks[0].polygon.back(), 50, 100);

  const std::vector<Image> mine = mattes_of(take_), theirs = replayed("closed-form");
  for (std::size_t f = 0; f < mine.size(); ++f)
    EXPECT_TRUE(!mine[f].empty() && mine[f] == theirs[f]) << "frame " << f;

  // The window as it stood at the end: the matte of frame 2, grey.
  const Result<Image> shot = load_png(folder_ / "floatstage-0.png");
  ASSERT_THAT(shot, IsOk());
  ASSERT_EQ(shot->width, 900);
  int points = 0, same = 0, subject = 0;
  for (int y = 5; y < 120; y += 5)
    for (int x = 3; x < 160; x += 5) {
      const int alpha = *mine[2].at(x, y), shown = shot->at(270 + static_cast<int>((x + 0.5) * 3.9375),
                                                            static_cast<int>(27.75 + (y + 0.5) * 3.9375))[0];
      ++points, same += std::abs(shown - alpha)<12, subject += alpha> 200;
    }
  EXPECT_GT(subject, 20);
  EXPECT_GT(same, points * 94 / 100) << "but for strokes and the brush above the matte";
}

TEST_F(MatteEditorUnderXvfb, MakesMattesAfterEveryEditWithSpectralMattingToo) {
  ASSERT_EQ(edit("--matte spectral --frame 1", R"(
at 80 60; x click 1
said 'mattes changed'
x key Right Right Right; at 80 64; x click 1
said 'mattes changed'
x key ctrl+q
)"),
            0)
      << output_;
  EXPECT_EQ(edits().keyframes.size(), 2u);
  EXPECT_EQ(mattes_of(take_), replayed("spectral"));
}

TEST_F(MatteEditorUnderXvfb, WorksOnWhatProcessMade) {
  ASSERT_EQ(
      std::system(
          text(FLOATSTAGE_PROGRAM, " process '", take_.string(), "' --matte chroma > /dev/null").c_str()),
      0);
  ASSERT_EQ(edit("--frame 1", R"(
x key h; at 20 60; x click 1
said 'mattes changed'
x key ctrl+q
)"),
            0)
      << output_;
  EXPECT_EQ(*mattes_of(take_)[1].at(20, 60), 255);
}

TEST_F(MatteEditorUnderXvfb, AsksInItsWindowBeforeItChangesMattesOfUnknownOrigin) {
  fs::copy(TakeLayout(take_).truth().mattes(), TakeLayout(take_).mattes(), fs::copy_options::recursive);
  ASSERT_EQ(edit("--frame 1", R"(
x key h; at 20 60; x click 1
said 'not made by Floatstage'
x key y
said 'mattes changed'
x key ctrl+q
)"),
            0)
      << output_;
  EXPECT_EQ(*mattes_of(take_)[1].at(20, 60), 255);
  EXPECT_TRUE(fs::exists(TakeLayout(take_).given_mattes(kSerial) / "000001.png"));
}

TEST_F(MatteEditorUnderXvfb, LeavesNothingHalfWrittenWhenTheWindowIsClosedInTheMiddle) {
  ASSERT_EQ(run_matte(take_, "--matte closed-form"), 0);
  ASSERT_EQ(edit("", R"(
x key h; at 20 60; x click 1
x key g; at 80 60; x click 1
x key ctrl+q
)"),
            0)
      << output_;
  EXPECT_EQ(edits().masks.size(), 2u);
  for (const Image& matte : mattes_of(take_)) EXPECT_FALSE(matte.empty());
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(take_))
    EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".tmp")));
  EXPECT_EQ(run_matte(take_, "--matte closed-form"), 0);
  EXPECT_EQ(mattes_of(take_), replayed("closed-form"));
}

TEST_F(MatteEditorUnderXvfb, SaysWhatIsWrongWithTheFileBeforeAWindowOpens) {
  fs::create_directory(TakeLayout(take_).mattes());
  folder_.write("take/mattes/edits.json", "{\"floatstage_edits\": 1, \"cam");
  EXPECT_NE(edit("", ""), 0);
  EXPECT_THAT(output_, HasSubstr("edits.json"));
}

}  // namespace
}  // namespace floatstage::apps
