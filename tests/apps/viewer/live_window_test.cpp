
#include <gmock/gmock.h>

#include "core/png.h"
#include "tests/support/run_command.h"
#include "tests/support/small_take.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

using testing::HasSubstr;

// The real window under a virtual display, closed by its own --screenshot.
TEST(LiveWindow, ShowsThePerformerAndTheStudiosPanels) {
  const TempFolder folder;
  const std::filesystem::path take = small_take(folder, 3), shot = folder / "shot.png";
  const Ended ended =
      run_command(under_display(FLOATSTAGE_PROGRAM " live --source " + take.string() +
                                " --seconds 60 --rate 8 --size 900x600 --screenshot " + shot.string()));
  ASSERT_EQ(ended.code, 0) << ended.output;
  const Result<Image> picture = load_png(shot);
  ASSERT_THAT(picture, IsOk());
  ASSERT_EQ(picture->width, 900);
  constexpr int kPanel = 270, kStatus = 28;
  long covered = 0, all = 0, text_pixels = 0;
  for (int y = 0; y < 600 - kStatus; ++y) {
    for (int x = 0; x < 900; ++x) {
      const std::uint8_t* p = picture->at(x, y);
      if (x < kPanel) {
        text_pixels += p[0] > 150;
      } else {
        covered += p[0] + p[1] + p[2] > 40;
        ++all;
      }
    }
  }
  EXPECT_GT(static_cast<double>(covered) / static_cast<double>(all), 0.02) << "nobody is on the stage";
  EXPECT_LT(static_cast<double>(covered) / static_cast<double>(all), 0.6);
  EXPECT_GT(text_pixels, 400) << "the panels have no text";
}

TEST(LiveVerb, SaysWhatIsMissing) {
  const Ended nothing = run_command(FLOATSTAGE_PROGRAM " live --headless");
  EXPECT_EQ(nothing.code, 3);
  EXPECT_THAT(nothing.output, HasSubstr("--source TAKE or --config STUDIO.toml"));
  const Ended unseen = run_command(FLOATSTAGE_PROGRAM " live --source /no/such/take --json L.json");
  EXPECT_EQ(unseen.code, 3);
  EXPECT_THAT(unseen.output, HasSubstr("add --headless"));
  const Ended nobody = run_command(FLOATSTAGE_PROGRAM " live --headless --config /no/such/studio.toml");
  EXPECT_EQ(nobody.code, 4);
  EXPECT_THAT(nobody.output, HasSubstr("/no/such/studio.toml"));
  const Ended lost = run_command(FLOATSTAGE_PROGRAM " live --headless --source /no/such/take");
  EXPECT_EQ(lost.code, 4);
  EXPECT_THAT(lost.output, HasSubstr("/no/such/take"));
}

}  // namespace
}  // namespace floatstage::apps
