#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "core/file.h"
#include "core/png.h"
#include "pipeline/process/process.h"
#include "tests/support/small_take.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

// The real window under a virtual display, closed by its own --screenshot.
class PlayUnderXvfb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    take_ = small_take(*folder_, 2);
    pipeline::ProcessOptions options{.take = take_, .matte = "chroma", .hull = recon::HullOptions{}};
    options.hull->resolution = 64;
    ASSERT_THAT(pipeline::process_take(options), IsOk());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  // Empty when the player failed; what it said is in `output`.
  Image screenshot(const std::string& arguments) {
    const std::filesystem::path file = *folder_ / "shot.png";
    std::filesystem::remove(file);
    const std::string command = under_display(FLOATSTAGE_PROGRAM " play " + take_.string() +
                                              " --size 900x600 --screenshot " + file.string() + " " +
                                              arguments + " 2>&1");
    FILE* pipe = popen(command.c_str(), "r");
    char buffer[4096];
    output_.clear();
    for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) output_.append(buffer, n);
    code_ = WEXITSTATUS(pclose(pipe));
    const Result<Image> image = load_png(file);
    return image ? *image : Image();
  }

  static TempFolder* folder_;
  static std::filesystem::path take_;
  std::string output_;
  int code_ = -1;
};
TempFolder* PlayUnderXvfb::folder_ = nullptr;
std::filesystem::path PlayUnderXvfb::take_;

constexpr int kPanel = 270, kTimeLine = 62;  // px of the window that are not the stage

struct Stage {
  double coverage = 0;         ///< fraction of stage pixels that are not the background
  double mean[3] = {0, 0, 0};  ///< colour of those
};

Stage look_at_stage(const Image& shot, int background) {
  Stage stage;
  long covered = 0, all = 0;
  for (int y = 0; y < shot.height - kTimeLine; ++y) {
    for (int x = kPanel; x < shot.width; ++x, ++all) {
      const std::uint8_t* p = shot.at(x, y);
      if (std::abs(p[0] - background) <= 3 && std::abs(p[1] - background) <= 3 &&
          std::abs(p[2] - background) <= 3)
        continue;
      ++covered;
      for (int c = 0; c < 3; ++c) stage.mean[c] += p[c];
    }
  }
  stage.coverage = static_cast<double>(covered) / static_cast<double>(all);
  for (double& m : stage.mean) m /= static_cast<double>(std::max(covered, 1L));
  return stage;
}

TEST_F(PlayUnderXvfb, ShowsThePerformerInTheMiddleAndThePanelsAround) {
  const Image shot = screenshot("--background 000000");
  ASSERT_FALSE(shot.empty()) << output_;
  EXPECT_EQ(code_, 0) << output_;
  ASSERT_EQ(shot.width, 900);
  const Stage stage = look_at_stage(shot, 0);
  EXPECT_GT(stage.coverage, 0.03) << "nobody is on the stage";
  EXPECT_LT(stage.coverage, 0.6);
  const double brightness = (stage.mean[0] + stage.mean[1] + stage.mean[2]) / 3;
  EXPECT_GT(brightness, 25);
  EXPECT_LT(brightness, 230);
  EXPECT_LT(stage.mean[1], std::max(stage.mean[0], stage.mean[2]) + 25)
      << "a green performer: the cloth shows";
  long panel_light = 0;
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < kPanel; ++x) panel_light += shot.at(x, y)[0] > 150;
  EXPECT_GT(panel_light, 200) << "the panel has no text";
}

TEST_F(PlayUnderXvfb, StandsUprightOnTheScreen) {
  const Image shot = screenshot("--background 000000 --method nearest");
  ASSERT_FALSE(shot.empty()) << output_;
  // The trousers are bluish, skin and hair reddish: the body turns from red to blue downwards.
  int top = shot.height, bottom = 0;
  for (int y = 0; y < shot.height - kTimeLine; ++y)
    for (int x = kPanel + 5; x < shot.width; ++x)
      if (shot.at(x, y)[0] > 60) top = std::min(top, y), bottom = std::max(bottom, y);
  ASSERT_GT(bottom - top, 200);
  auto redness = [&](int from, int to) {
    double sum = 0, count = 1;
    for (int y = from; y < to; ++y)
      for (int x = kPanel + 5; x < shot.width; ++x)
        if (shot.at(x, y)[0] + shot.at(x, y)[1] + shot.at(x, y)[2] > 60)
          sum += shot.at(x, y)[0] - shot.at(x, y)[2], ++count;
    return sum / count;
  };
  const int height = bottom - top;
  EXPECT_GT(redness(top, top + height / 5), redness(top + height * 11 / 20, top + height * 17 / 20) + 15);
}

TEST_F(PlayUnderXvfb, SplitsTheScreenBetweenTwoMethods) {
  const Image whole = screenshot("--method floating --background 000000"),
              split = screenshot("--method linear --compare floating --background 000000");
  ASSERT_FALSE(whole.empty() || split.empty()) << output_;
  long right_differs = 0, line = 0;
  const int middle = kPanel + (900 - kPanel) / 2;
  for (int y = 40; y < 600 - kTimeLine; ++y) {
    for (int x = middle + 40; x < 900; ++x)
      right_differs += std::abs(whole.at(x, y)[0] - split.at(x, y)[0]) > 3;
    for (int x = middle - 2; x <= middle + 2; ++x) line += split.at(x, y)[0] > 200 && split.at(x, y)[2] < 130;
  }
  EXPECT_EQ(right_differs, 0) << "the right half is the floating picture";
  EXPECT_GT(line, 300) << "no line between the halves";
}

TEST_F(PlayUnderXvfb, ShowsCamerasAndIntermediates) {
  const double plain = look_at_stage(screenshot("--background 000000"), 0).coverage;
  EXPECT_GT(look_at_stage(screenshot("--background 000000 --show-cameras"), 0).coverage, plain)
      << "no frusta";
  const Stage weights = look_at_stage(screenshot("--background 000000 --show weights"), 0);
  EXPECT_GT(weights.coverage, plain / 2);
}

TEST_F(PlayUnderXvfb, LosesNoInputHoweverQuickTheHandIs) {
  const std::string json = (*folder_ / "play.json").string();
  const std::string hands = (*folder_)
                                .write("hands.sh", R"(
)" FLOATSTAGE_PROGRAM R"( play ')" + take_.string() + R"(' --size 900x600 --json ')" +
                                                       json + R"(' &
player=$!
window=$(xdotool search --sync --onlyvisible --name Floatstage | head -1)
xdotool windowmove --sync $window 0 0 2>/dev/null
xdotool windowfocus --sync $window
sleep 1
for x in $(seq 500 4 700); do echo mousemove $x 300; done > moves
xdotool mousemove --sync 500 300 mousedown 1
xdotool - < moves
xdotool mouseup 1
for i in $(seq 100); do echo mousemove $((500 + i % 2 * 40)) 300 mousedown 1 mousemove $((540 - i % 2 * 40)) 310 mouseup 1; done > drags
xdotool - < drags
for i in $(seq 101); do echo key Right; done > keys
xdotool - < keys
sleep 2
kill -INT $player
wait $player
)")
                                .string();
  const std::string command =
      "cd " + folder_->path().string() + " && " + under_display("bash " + hands + " 2>&1");
  FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  std::string output;
  for (std::size_t n; (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.append(buffer, n);
  EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 0) << output;
  const Result<std::string> bytes = read_file(json);
  ASSERT_THAT(bytes, IsOk()) << output;
  const nlohmann::json report = nlohmann::json::parse(*bytes);
  EXPECT_EQ(report.at("frame"), 1) << "a hundred and one arrows between two frames: " << report.dump();
  EXPECT_EQ(report.at("keys"), 101) << report.dump();
  EXPECT_EQ(report.at("presses"), 101) << "a slow drag and a hundred quick ones: " << report.dump();
  EXPECT_GT(report.at("after_input").at("pictures"), 0) << report.dump();
  EXPECT_GT(report.at("moving").at("pictures"), 0) << report.dump();
  EXPECT_GE(report.at("at_rest").at("pictures"), 2) << "before the drag and after it: " << report.dump();
  EXPECT_GE(report.at("events"), 7) << report.dump();
}

TEST_F(PlayUnderXvfb, SaysWhatIsWrongBeforeAWindowOpens) {
  EXPECT_TRUE(screenshot("--method flaoting").empty());
  EXPECT_EQ(code_, 3);
  EXPECT_THAT(output_, testing::HasSubstr("floating"));
  EXPECT_TRUE(screenshot("--frame 99").empty());
  EXPECT_THAT(output_, testing::HasSubstr("frame 99"));
}

TEST(PlayWithoutADisplay, SaysSo) {
  FILE* pipe = popen("env -u DISPLAY -u WAYLAND_DISPLAY " FLOATSTAGE_PROGRAM " play /no/such/take 2>&1", "r");
  char buffer[1024] = {};
  const std::size_t n = fread(buffer, 1, sizeof buffer - 1, pipe);
  EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 4);
  EXPECT_THAT(std::string(buffer, n), testing::HasSubstr("/no/such/take"));
}

}  // namespace
}  // namespace floatstage::apps
