#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

using detail::test::photograph;
using detail::test::view_of_world;
using testing::HasSubstr;

constexpr int kPanel = 270, kStrip = 28, kWidth = 900, kHeight = 600;  // px of the window

// The real window under a virtual display, closed by its own --screenshot.
class ZoomWindowUnderXvfb : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "photos");
    ASSERT_THAT(save_png(photograph(240, 180, view_of_world(0, 0, 4)), folder_ / "photos/wide.png"), IsOk());
    ASSERT_THAT(save_png(photograph(240, 180, view_of_world(330, 190, 1.5)), folder_ / "photos/close.png"),
                IsOk());
    const Ended ended = run_command(FLOATSTAGE_PROGRAM " detail graph " + (folder_ / "photos").string() +
                                    " --json " + graph());
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  std::string graph() const { return (folder_ / "graph.json").string(); }
  Ended view(const std::string& arguments) const {
    return run_command(
        under_display(FLOATSTAGE_PROGRAM " detail view " + graph() + " --size 900x600 " + arguments));
  }
  // The part of the window between two columns of the stage.
  static Image stage(const Image& window, int from, int to) {
    Image part(to - from, kHeight - kStrip, 3);
    for (int y = 0; y < part.height; ++y)
      std::copy_n(window.at(kPanel + from, y), 3 * static_cast<std::size_t>(part.width), part.at(0, y));
    return part;
  }
  TempFolder folder_;
};

TEST_F(ZoomWindowUnderXvfb, ShowsTheCloseWorldAndTheWideOneEnlargedAtTheRightOfTheSplit) {
  const std::string whole = (folder_ / "whole.png").string(), split = (folder_ / "split.png").string(),
                    json = (folder_ / "report.json").string();
  const Ended flown = view("--at 127,81 --zoom 9 --fly --screenshot " + whole + " --json " + json);
  ASSERT_EQ(flown.code, 0) << flown.output;
  const Ended ended = view("--at 127,81 --zoom 9 --split --screenshot " + split);
  ASSERT_EQ(ended.code, 0) << ended.output;
  ASSERT_EQ(load_png(whole)->width, kWidth);
  // What the close photograph's resolution shows of the world there.
  constexpr int kStage = kWidth - kPanel, kRows = kHeight - kStrip, kFrom = 420, kTo = 590;
  Image truth(kTo - kFrom, kRows, 3);
  for (int y = 0; y < kRows; ++y)
    for (int x = kFrom; x < kTo; ++x)
      for (int c = 0; c < 3; ++c)
        truth.at(x - kFrom, y)[c] = static_cast<std::uint8_t>(
            std::lround(255 * detail::test::world(4 * (127 + (x + 0.5 - kStage / 2.0) / 9),
                                                  4 * (81 + (y + 0.5 - kRows / 2.0) / 9), 1, 2 * 1.5)[c]));
  const double close = psnr(stage(*load_png(whole), kFrom, kTo), truth),
               wide = psnr(stage(*load_png(split), kFrom, kTo), truth);
  EXPECT_GT(close, wide + 3) << "dB";
  EXPECT_EQ(stage(*load_png(whole), 0, 150), stage(*load_png(split), 0, 150)) << "the left is as it was";
  const nlohmann::json report = nlohmann::json::parse(*read_file(json));
  EXPECT_NEAR(report.at("zoom"), 9, 1e-6);
  EXPECT_GT(report.at("steps"), 50) << "it flew there";
  EXPECT_EQ(report.at("photos")[0].at("name"), "close.png");
  EXPECT_GT(report.at("video_memory_bytes"), 4 * 240 * 180);
  EXPECT_NEAR(report.at("finest"), 4 / 1.5, 0.05);
}

TEST_F(ZoomWindowUnderXvfb, PaintsWherePixelsComeFrom) {
  const std::string shot = (folder_ / "shot.png").string();
  const Ended ended = view("--overlay both --screenshot " + shot);
  ASSERT_EQ(ended.code, 0) << ended.output;
  const Image picture = *load_png(shot);
  // Colours above grey's in the middle, where the close photograph lies, and at a corner of the root.
  const auto tint = [&](int x, int y) {
    double sum = 0;
    for (int v = y - 20; v < y + 20; ++v)
      for (int u = x - 20; u < x + 20; ++u) {
        const std::uint8_t* p = picture.at(u, v);
        sum += std::max(p[1], p[2]) - p[0];
      }
    return sum / 1600;
  };
  const int middle_x = kPanel + (kWidth - kPanel) / 2, middle_y = (kHeight - kStrip) / 2;
  EXPECT_GT(tint(middle_x, middle_y), tint(kPanel + 40, middle_y + 180) + 25);
}

TEST_F(ZoomWindowUnderXvfb, SaysWhatIsWrongWithoutAWindow) {
  const Ended far = view("--at 900,20 --screenshot " + (folder_ / "shot.png").string());
  EXPECT_EQ(far.code, 3) << far.output;
  EXPECT_THAT(far.output, HasSubstr("wide.png has 240x180 px"));
  const Ended small = view("--video-memory 0.1 --screenshot " + (folder_ / "shot.png").string());
  EXPECT_EQ(small.code, 3);
  EXPECT_THAT(small.output, HasSubstr("video memory"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "shot.png"));
}

}  // namespace
}  // namespace floatstage::apps
