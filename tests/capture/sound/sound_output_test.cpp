#include "capture/sound/sound_output.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sound/media_sound.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

std::vector<float> both(std::size_t samples, float level) {
  return std::vector<float>(samples * kOutputChannels, level);
}

TEST(ASoundOutput, HearsWhatWasWrittenWhenItsTimeComes) {
  Timestamp now{1'000'000'000};
  const auto output = silent_output([&] { return now; });
  const auto room = output->room();
  ASSERT_THAT(room, IsOk());
  EXPECT_EQ(*room, static_cast<std::int64_t>(kOutputBuffer * kPlayOutRate));
  ASSERT_THAT(output->write(both(4800, 0.5f)), IsOk());
  EXPECT_THAT(output->heard(), IsOkAnd(0));
  EXPECT_THAT(output->room(), IsOkAnd(*room - 4800));
  now = now + milliseconds(50);
  EXPECT_THAT(output->heard(), IsOkAnd(2400));
  EXPECT_NEAR(output->clock(), 0.05, 1e-9);
  now = now + milliseconds(500);
  EXPECT_THAT(output->heard(), IsOkAnd(4800)) << "it ran dry, and is silent";
  ASSERT_THAT(output->write(both(4800, 0.5f)), IsOk());
  now = now + milliseconds(25);
  EXPECT_THAT(output->heard(), IsOkAnd(4800 + 1200));
  output->drop();
  EXPECT_THAT(output->heard(), IsOkAnd(0));
  EXPECT_THAT(output->room(), IsOkAnd(*room));
}

TEST(ASoundOutput, OfAFileIsAWavThatOthersRead) {
  const TempFolder folder;
  const std::string path = folder / "heard.wav";
  {
    const auto output = open_sound_output("file:" + path + "?ppm=0");
    ASSERT_THAT(output, IsOk());
    ASSERT_THAT((*output)->write(both(960, 0.5f)), IsOk());
    for (Result<std::int64_t> heard = 0; heard && *heard < 960;) heard = (*output)->heard();
  }
  const auto sound = MediaSound::open(path);
  ASSERT_THAT(sound, IsOk());
  ASSERT_TRUE(*sound);
  EXPECT_EQ((*sound)->rate(), kPlayOutRate);
  EXPECT_EQ((*sound)->channels(), kOutputChannels);
  std::size_t loud = 0;
  for (;;) {
    const auto block = (*sound)->next();
    if (!block) break;
    for (const float level : block->samples) loud += std::abs(level - 0.5f) < 1e-3f ? 1 : 0;
  }
  EXPECT_EQ(loud, 960u * kOutputChannels);
}

TEST(ASoundOutput, IsRefusedInWordsThatSayWhatThereIs) {
  for (const char* uri :
       {"", "alsa", "alsa:", "radio:1", "none:1", "file:", "file:a?ppm=x", "file:a?ppm=1001"})
    EXPECT_THAT(open_sound_output(uri), FailsWith(ErrorCode::InvalidArgument, "alsa:DEVICE")) << uri;
  EXPECT_THAT(open_sound_output("file:/no/such/folder/a.wav"),
              FailsWith(ErrorCode::Io, "/no/such/folder/a.wav"));
  EXPECT_THAT(open_sound_output("alsa:no-such-device"),
              FailsWith(ErrorCode::NotFound, "cannot play to alsa:no-such-device"));
}

// Every machine has this one. It swallows at once, or by a clock, as its version likes.
TEST(ASoundOutput, PlaysToADeviceOfAlsa) {
  const auto output = open_sound_output("alsa:null");
  ASSERT_THAT(output, IsOk());
  const auto room = (*output)->room();
  ASSERT_THAT(room, IsOk());
  EXPECT_GT(*room, 0);
  ASSERT_THAT((*output)->write(both(480, 0.1f)), IsOk());
  const auto heard = (*output)->heard();
  ASSERT_THAT(heard, IsOk());
  EXPECT_GE(*heard, 0);
  EXPECT_LE(*heard, 480);
  (*output)->drop();
  EXPECT_THAT((*output)->heard(), IsOkAnd(0));
}

}  // namespace
}  // namespace floatstage::capture
