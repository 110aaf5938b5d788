// The real program with a decoder that somebody has taken over (hostile_decoder.cpp stands before libav's).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "calib/formats/format_files.h"
#include "capture/media_file.h"
#include "core/png.h"
#include "tests/hostile/hostile_run.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kBadData = 6, kSeconds = 60;

class HostileDecoder : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "in");
    for (const char* name : {"a", "b"})
      ASSERT_THAT(save_png(pipeline::test_picture(0, 0), folder_ / "in" / (std::string(name) + ".png")),
                  IsOk());
    ASSERT_THAT(calib::write_middlebury(pipeline::test_rig(2), {"a.png", "b.png"}, folder_ / "in/x_par.txt"),
                IsOk());
    fs::create_directories(folder_ / "out");
  }

  HostileRun run(std::vector<std::string> words, int seconds = kSeconds) const {
    words.insert(words.begin(), FLOATSTAGE_PROGRAM);
    return hostile_run(
        words, seconds,
        {"LD_PRELOAD=" FLOATSTAGE_HOSTILE_DECODER, std::string("FLOATSTAGE_HOSTILE=") + GetParam(),
         "FLOATSTAGE_ELSEWHERE=" + (folder_ / "elsewhere").string()});
  }
  HostileRun import(int seconds = kSeconds) const {
    return run({"import", "middlebury", folder_ / "in", "-o", folder_ / "out/take"}, seconds);
  }
  // Neither a take nor a half of it, nor anything that the decoder wanted to leave.
  void expect_nothing_left() const {
    EXPECT_TRUE(fs::is_empty(folder_ / "out"));
    EXPECT_FALSE(fs::exists(folder_ / "elsewhere"));
  }

  const TempFolder folder_;
};

TEST_P(HostileDecoder, BecomesASentenceOfItsFileAndLeavesNothing) {
  const HostileRun ended = import();
  ASSERT_TRUE(WIFEXITED(ended.status)) << ended.status << ": " << ended.said;
  EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << ended.said;
  EXPECT_THAT(ended.said, HasSubstr((folder_ / "in").string()));
  EXPECT_THAT(ended.said, HasSubstr(".png: "));
  expect_nothing_left();
}

INSTANTIATE_TEST_SUITE_P(That, HostileDecoder,
                         testing::Values("connect", "exec", "shell", "kill", "eat", "crash", "abort",
                                         "exit"));

using SilentDecoder = HostileDecoder;

TEST_P(SilentDecoder, WritesNothingElsewhere) {
  const HostileRun ended = import();
  EXPECT_EQ(WEXITSTATUS(ended.status), 0) << ended.said;
  EXPECT_FALSE(fs::exists(folder_ / "elsewhere"));
}

INSTANTIATE_TEST_SUITE_P(That, SilentDecoder, testing::Values("write"));

using ClipDecoder = HostileDecoder;

TEST_P(ClipDecoder, OfAVideoWithoutATakeDoesNoMore) {
  auto video = capture::VideoWriter::create(folder_ / "in/clip.mp4", 32, 24, 25);
  ASSERT_THAT(video, IsOk());
  for (int f = 0; f < 3; ++f) ASSERT_THAT((*video)->write(pipeline::test_picture(0, f)), IsOk());
  ASSERT_THAT((*video)->finish(), IsOk());
  ASSERT_THAT(save_png(Image(32, 24, 1), folder_ / "in/mask.png"), IsOk());
  const HostileRun ended = run(
      {"matte", folder_ / "in/clip.mp4", "--guide", folder_ / "in/mask.png", "-o", folder_ / "out/mattes"});
  ASSERT_TRUE(WIFEXITED(ended.status)) << ended.said;
  EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << ended.said;
  EXPECT_THAT(ended.said, HasSubstr("clip.mp4: "));
  expect_nothing_left();
}

INSTANTIATE_TEST_SUITE_P(That, ClipDecoder, testing::Values("connect", "crash"));

using EndlessDecoder = HostileDecoder;

// A minute of processor time for each file that is being decoded (the core's tests have a shorter limit).
TEST_P(EndlessDecoder, IsEndedToo) {
  if (!wants_long_tests()) GTEST_SKIP() << "two minutes; FLOATSTAGE_LONG=1";
  const HostileRun ended = import(400);
  ASSERT_TRUE(WIFEXITED(ended.status)) << ended.said;
  EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << ended.said;
  EXPECT_THAT(ended.said, HasSubstr(".png: not decoded after 60 s of processor time"));
  expect_nothing_left();
}

INSTANTIATE_TEST_SUITE_P(That, EndlessDecoder, testing::Values("spin"));

}  // namespace
}  // namespace floatstage
