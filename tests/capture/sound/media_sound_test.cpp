#include "capture/sound/media_sound.h"

#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;

template <class T>
std::string bytes_of(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

// A WAV file; format 1 is PCM, 3 floats.
std::string wav(int format, int channels, int rate, int bits, const std::string& samples) {
  const int sample = channels * bits / 8;
  return "RIFF" + bytes_of(static_cast<std::uint32_t>(36 + samples.size())) + "WAVEfmt " +
         bytes_of(std::uint32_t{16}) + bytes_of(static_cast<std::uint16_t>(format)) +
         bytes_of(static_cast<std::uint16_t>(channels)) + bytes_of(rate) + bytes_of(rate * sample) +
         bytes_of(static_cast<std::uint16_t>(sample)) + bytes_of(static_cast<std::uint16_t>(bits)) + "data" +
         bytes_of(static_cast<std::uint32_t>(samples.size())) + samples;
}

class MediaSoundOf : public testing::Test {
 protected:
  Result<std::unique_ptr<MediaSound>> open(const std::string& bytes) {
    return MediaSound::open(folder_.write("sound.wav", bytes));
  }
  static std::vector<float> all(MediaSound& sound) {
    std::vector<float> out;
    for (;;) {
      const auto block = sound.next();
      if (!block) {
        EXPECT_EQ(block.error().code, ErrorCode::EndOfStream) << block.error().message;
        return out;
      }
      out.insert(out.end(), block->samples.begin(), block->samples.end());
    }
  }
  TempFolder folder_;
};

TEST_F(MediaSoundOf, AWavIsItsSamples) {
  const auto sound = open(wav(1, 2, 44'100, 16,
                              bytes_of(std::int16_t{-32768}) + bytes_of(std::int16_t{1}) +
                                  bytes_of(std::int16_t{0}) + bytes_of(std::int16_t{32767})));
  ASSERT_THAT(sound, IsOk());
  EXPECT_EQ((*sound)->rate(), 44'100);
  EXPECT_EQ((*sound)->channels(), 2);
  EXPECT_EQ((*sound)->bits(), 16);
  EXPECT_THAT(all(**sound), ElementsAre(-1.f, 1 / 32768.f, 0.f, 32767 / 32768.f));
}

TEST_F(MediaSoundOf, FloatsKeepWhatIsFiniteAndSilenceTheRest) {
  const auto sound = open(wav(3, 1, 48'000, 32, bytes_of(0.25f) + bytes_of(NAN) + bytes_of(-INFINITY)));
  ASSERT_THAT(sound, IsOk());
  EXPECT_EQ((*sound)->bits(), 24);
  EXPECT_THAT(all(**sound), ElementsAre(0.25f, 0.f, 0.f));
}

TEST_F(MediaSoundOf, ATrackWithoutASampleSaysSo) {
  const auto sound = open(wav(1, 1, 48'000, 16, ""));
  if (!sound)
    EXPECT_THAT(sound, FailsWith(ErrorCode::BadData, "sound.wav"));
  else
    EXPECT_THAT((*sound)->next(), FailsWith(ErrorCode::BadData, "holds no sound at all"));
}

TEST_F(MediaSoundOf, NoChannelsOrAnImpossibleRateAreRefused) {
  const std::string some(400, '\1');
  EXPECT_THAT(open(wav(1, 0, 48'000, 16, some)), FailsWith(ErrorCode::BadData, "sound.wav"));
  EXPECT_THAT(open(wav(1, 1, 0, 16, some)), FailsWith(ErrorCode::BadData, "sound.wav"));
  EXPECT_THAT(open(wav(1, 1, 500, 16, some)), FailsWith(ErrorCode::BadData, "500 samples a second"));
  EXPECT_THAT(open(wav(1, 20, 48'000, 16, some)), FailsWith(ErrorCode::BadData, "20 channels"));
  EXPECT_THAT(open(""), FailsWith(ErrorCode::BadData, "sound.wav"));
  EXPECT_THAT(MediaSound::open(folder_ / "none.wav"), FailsWith(ErrorCode::NotFound, "none.wav"));
}

TEST_F(MediaSoundOf, AFlacFileThatIsCutOffIsRefusedWhereverItIsCut) {
  std::string samples;
  for (std::int64_t i = 0; i < 48'000; ++i) samples += bytes_of(static_cast<std::int16_t>(i * i % 20'011));
  const auto from = folder_.write("whole.wav", wav(1, 1, 48'000, 16, samples)), to = folder_ / "whole.flac";
  const Ended made = run_command("ffmpeg -v error -i " + from.string() + " " + to.string());
  ASSERT_EQ(made.code, 0) << made.output;
  const std::string whole = *read_file(to);
  const auto last_word = [&](const std::string& bytes) -> Result<void> {
    const auto sound = MediaSound::open(folder_.write("cut.flac", bytes));
    if (!sound) return forward(sound);
    for (;;)
      if (const auto block = (*sound)->next(); !block) return forward(block);
  };
  EXPECT_THAT(last_word(whole), FailsWith(ErrorCode::EndOfStream, "no more sound"));
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += whole.size() / 60)
    EXPECT_THAT(last_word(whole.substr(0, bytes)), FailsWith(ErrorCode::BadData, "cut.flac")) << bytes;
}

TEST_F(MediaSoundOf, AFilmOfPicturesAloneIsNone) {
  auto writer = VideoWriter::create(folder_ / "film.mp4", 64, 48, 25);
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->write(Image(64, 48, 3)), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  const auto sound = MediaSound::open(folder_ / "film.mp4");
  ASSERT_THAT(sound, IsOk());
  EXPECT_FALSE(*sound);
}

}  // namespace
}  // namespace floatstage::capture
