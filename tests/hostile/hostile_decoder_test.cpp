// The real program with a decoder that somebody has taken over (hostile_decoder.cpp stands before libav's).

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "calib/formats/format_files.h"
#include "capture/media_file.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/png.h"
#include "tests/hostile/hostile_run.h"
#include "tests/hostile/zoom_folder.h"
#include "tests/pipeline/derive/sound_files.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr int kBadData = 6, kSeconds = 60;

class HostileDecoder : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (kSanitized)
      GTEST_SKIP() << "sanitizers load nothing before themselves, and end a crash in their own way";
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
    return run_words(words, seconds);
  }
  HostileRun run_words(const std::vector<std::string>& words, int seconds) const {
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

using SoundDecoder = HostileDecoder;

TEST_P(SoundDecoder, OfAnotherRecordersFileDoesNoMore) {
  capture::TakeWriterOptions options;
  options.codec = capture::TakeCodec::Raw;
  options.frame_rate = 25;
  const auto writer = capture::TakeWriter::create(folder_ / "in/take", pipeline::test_rig(1), options);
  ASSERT_THAT(writer, IsOk());
  FrameInfo info;
  info.camera = 0;
  ASSERT_THAT((*writer)->write(make_frame(info, pipeline::test_picture(0, 0))), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  ASSERT_THAT(write_file(folder_ / "in/rec.wav", pipeline::wav_file(std::vector<float>(800, 0.5f), 1, 8'000)),
              IsOk());
  const HostileRun ended = run({"take", "set-sound", folder_ / "in/take", folder_ / "in/rec.wav", "--at", "0",
                                "-o", folder_ / "out/take"});
  ASSERT_TRUE(WIFEXITED(ended.status)) << ended.said;
  EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << ended.said;
  EXPECT_THAT(ended.said, HasSubstr("rec.wav: "));
  expect_nothing_left();
}

INSTANTIATE_TEST_SUITE_P(That, SoundDecoder,
                         testing::Values("connect", "exec", "kill", "eat", "crash", "exit"));

// Of photographs, which detail and matte-image read.
class PhotoDecoder : public HostileDecoder {
 protected:
  void SetUp() override {
    HostileDecoder::SetUp();
    fs::create_directories(folder_ / "in/zoom");
    write_zoom_folder(folder_ / "in/zoom");
  }
  std::vector<std::vector<std::string>> verbs() const {
    const std::string in = folder_ / "in/zoom/", out = folder_ / "out/";
    return {{"detail", "graph", in, "--json", out + "graph.json", "--dot", out + "graph.dot"},
            {"detail", "compose", in + kZoomGraph, "-o", out + "zoom.png", "--json", out + "zoom.json",
             "--steps", out + "steps", "--zoom", "1.5"},
            {"detail", "synthesize", in + kZoomGraph, "-o", out + "large.dzi", "--provenance",
             out + "from.png", "--zoom", "2"},
            {"matte-image", in + kClosePhoto, "-o", out + "matte.png", "--foreground", out + "colors.png",
             "--subject", "100,90", "--background", "5,5", "--matte", "pyramid"},
            {"matte-image", folder_ / "in/a.png", "-o", out + "matte.png", "--subject", "16,12",
             "--background", "1,1", "--matte", "pyramid"}};
  }
  // As on a machine with little memory: what a photograph's decoder may have is bounded by what is free.
  HostileRun run_small(std::vector<std::string> words, int seconds = kSeconds) const {
    words.insert(words.begin(),
                 {"/bin/sh", "-c", "ulimit -v 4000000; exec \"$@\"", "sh", FLOATSTAGE_PROGRAM});
    return run_words(words, seconds);
  }
};

TEST_P(PhotoDecoder, BecomesASentenceOfItsFileAndLeavesNothing) {
  std::vector<std::vector<std::string>> readers = verbs();
  readers.push_back({"detail", "view", folder_ / "in/zoom/graph.json"});  // before there is a window
  for (const std::vector<std::string>& verb : readers) {
    const HostileRun ended = run_small(verb);
    ASSERT_TRUE(WIFEXITED(ended.status)) << verb[0] << ' ' << verb[1] << ended.status << ": " << ended.said;
    EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << verb[0] << ' ' << verb[1] << ended.said;
    EXPECT_THAT(ended.said, HasSubstr((folder_ / "in").string()));
    EXPECT_THAT(ended.said, testing::AnyOf(HasSubstr(".jpg: "), HasSubstr(".tif: "), HasSubstr(".png: "),
                                           HasSubstr(".jpg or "), HasSubstr(".tif or ")));
    expect_nothing_left();
  }
}

INSTANTIATE_TEST_SUITE_P(That, PhotoDecoder,
                         testing::Values("connect", "exec", "kill", "eat", "crash", "exit"));

using SilentPhotoDecoder = PhotoDecoder;

TEST_P(SilentPhotoDecoder, WritesNothingElsewhere) {
  for (const std::vector<std::string>& verb : verbs()) {
    const HostileRun ended = run_small(verb);
    EXPECT_EQ(WEXITSTATUS(ended.status), 0) << verb[0] << ' ' << verb[1] << ended.said;
    EXPECT_FALSE(fs::exists(folder_ / "elsewhere"));
  }
}

INSTANTIATE_TEST_SUITE_P(That, SilentPhotoDecoder, testing::Values("write"));

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

using EndlessPhotoDecoder = PhotoDecoder;

TEST_P(EndlessPhotoDecoder, IsEndedToo) {
  if (!wants_long_tests()) GTEST_SKIP() << "a minute and a half; FLOATSTAGE_LONG=1";
  const HostileRun ended = run_small(verbs()[3], 400);
  ASSERT_TRUE(WIFEXITED(ended.status)) << ended.said;
  EXPECT_EQ(WEXITSTATUS(ended.status), kBadData) << ended.said;
  EXPECT_THAT(ended.said, HasSubstr("close.tif: not decoded after 60 s of processor time"));
  expect_nothing_left();
}

INSTANTIATE_TEST_SUITE_P(That, EndlessPhotoDecoder, testing::Values("spin"));

}  // namespace
}  // namespace floatstage
