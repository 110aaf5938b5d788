// docs/tutorials/ as their readers follow them: every command of a page, in its order, in one empty folder.

#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/end_to_end/tutorial_page.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const fs::path kPages = source_folder() / "docs/tutorials";

TEST(TutorialPage, ItsStepsAreCommandsAndTheOutputRightBehindThem) {
  const std::vector<TutorialStep> steps = tutorial_steps(
      "# Page\n\n```sh\none\ntwo\n```\n\n```text\nfirst …\n```\nprose\n"
      "```text\nno output\n```\n```toml\nx\n```\n"
      "```sh\nthree\n```\nprose\n\n```text\nof nobody\n```\n");
  ASSERT_THAT(steps, SizeIs(2));
  EXPECT_EQ(steps[0].line, 4);
  EXPECT_EQ(steps[0].commands, "one\ntwo\n");
  EXPECT_THAT(steps[0].expected, ElementsAre("first …"));
  EXPECT_EQ(steps[1].commands, "three\n");
  EXPECT_THAT(steps[1].expected, IsEmpty());
}

TEST(TutorialPage, OutputIsWhatItShowsWithAnythingForEllipses) {
  EXPECT_TRUE(shows("t: 6 frames of 8 cameras; 3.2 s", "t: 6 frames of … cameras; …"));
  EXPECT_TRUE(shows("first      2026-11-23   6   PASS", "first … 6 … PASS"));
  EXPECT_FALSE(shows("t: 6 frames of 8 cameras", "t: 7 frames of … cameras"));
  EXPECT_FALSE(shows("PASS then first", "first … PASS")) << "in this order";
  const TutorialStep step = {.line = 1, .commands = {}, .expected = {"made 48", "kept …"}};
  EXPECT_EQ(first_missing(step, "made 48\nkept 2\n"), "");
  EXPECT_EQ(first_missing(step, "made 48\n"), "kept …");
}

// Follows a page from its first command to its last in `folder`.
void follow(const char* page, const fs::path& folder) {
  const Result<std::string> text = read_file(kPages / page);
  ASSERT_THAT(text, IsOk());
  const std::vector<TutorialStep> steps = tutorial_steps(*text);
  ASSERT_FALSE(steps.empty());
  const fs::path programs = fs::path(FLOATSTAGE_PROGRAM).parent_path();
  for (const TutorialStep& step : steps) {
    ASSERT_THAT(write_file(folder / ".step.sh", step.commands), IsOk());
    const Ended ended = run_command("cd '" + folder.string() + "' && PATH='" + programs.string() +
                                    "':\"$PATH\" bash -eu -o pipefail .step.sh < /dev/null");
    ASSERT_EQ(ended.code, 0) << page << ":" << step.line << "\n" << step.commands << ended.output;
    EXPECT_EQ(first_missing(step, ended.output), "") << page << ":" << step.line << "\n" << ended.output;
  }
}

class Tutorials : public testing::Test {
 protected:
  TempFolder folder_;
};

TEST_F(Tutorials, AStudioDay) {
  follow("a-studio-day.md", folder_.path());
  EXPECT_TRUE(fs::exists(folder_ / "page/index.html"));
}

TEST_F(Tutorials, ReprocessARecording) { follow("reprocess-a-recording.md", folder_.path()); }

TEST_F(Tutorials, ReplayInCi) { follow("replay-in-ci.md", folder_.path()); }

TEST_F(Tutorials, FromColmapToFilm) {
  const fs::path temple = data_folder() / "middlebury-temple-ring";
  ASSERT_TRUE(fs::exists(temple)) << "the photographs that the page is tried with";
  fs::create_directory(folder_ / "photographs");
  for (const fs::directory_entry& file : fs::directory_iterator(temple))
    if (file.path().extension() == ".png")
      fs::create_symlink(file.path(), folder_ / "photographs" / file.path().filename());
  follow("from-colmap-to-film.md", folder_.path());
}

TEST_F(Tutorials, FromATakeToSplats) { follow("from-take-to-splats.md", folder_.path()); }

TEST(TutorialPages, AreAllFollowedAndListed) {
  const Result<std::string> index = read_file(kPages / "README.md");
  ASSERT_THAT(index, IsOk());
  int pages = 0;
  for (const fs::directory_entry& page : fs::directory_iterator(kPages)) {
    const std::string name = page.path().filename().string();
    if (name == "README.md") continue;
    ++pages;
    EXPECT_THAT(*index, testing::HasSubstr("(" + name + ")"));
  }
  EXPECT_EQ(pages, 5) << "a new page needs a test here";
}

}  // namespace
}  // namespace floatstage
