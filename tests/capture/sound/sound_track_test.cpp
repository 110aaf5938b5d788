#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/capture/sound/sound_support.h"
#include "tests/support/child_process.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const auto kGoOn = [](std::uint64_t) { return true; };

class ATrackOfSound : public testing::Test {
 protected:
  std::unique_ptr<SoundReader> open(const SoundTrack& track) {
    auto sound = SoundReader::open(take_, track);
    EXPECT_THAT(sound, IsOk());
    return sound ? std::move(*sound) : nullptr;
  }
  std::filesystem::path media() const { return folder_ / track_.media(); }

  TempFolder folder_;
  const TakeLayout take_{folder_.path()};
  const SoundTrack track_ = {.name = "mic", .rate = 48'000, .channels = 2, .bits = 16, .from = "test"};
};

TEST_F(ATrackOfSound, ReturnsEverySampleAsItWas) {
  for (const int bits : {16, 24})
    for (const int channels : {1, 2, 8}) {
      SoundTrack track = track_;
      track.bits = bits, track.channels = channels;
      track.name = "mic" + std::to_string(bits) + "-" + std::to_string(channels);
      constexpr std::int64_t kSamples = 10 * kSoundBlock + 77;
      record(take_, track, kSamples);
      const auto sound = open(track);
      EXPECT_EQ(sound->samples(), kSamples);
      EXPECT_EQ(read(*sound, 0, kSamples), patterned(0, kSamples, channels));
      EXPECT_EQ(read(*sound, 3 * kSoundBlock - 5, 10), patterned(3 * kSoundBlock - 5, 10, channels));
      EXPECT_THAT(sound->warnings(), IsEmpty());
      EXPECT_THAT(sound->damage(kGoOn), IsOkAnd(IsEmpty()));
    }
}

TEST_F(ATrackOfSound, IsSilentBeforeItsBeginAndAfterItsEnd) {
  record(take_, track_, 2000);
  const auto sound = open(track_);
  const std::vector<float> around = read(*sound, -10, 2020), inside = patterned(0, 2000, 2);
  EXPECT_EQ(std::vector<float>(around.begin() + 20, around.end() - 20), inside);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(around[i], 0.f);
    EXPECT_EQ(around[around.size() - 1 - i], 0.f);
  }
}

TEST_F(ATrackOfSound, CutsWhatIsTooLoudAndSilencesWhatIsNoNumber) {
  const auto writer = SoundWriter::create(take_, track_);
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->stamp(0, {0}), IsOk());
  ASSERT_THAT((*writer)->write(std::vector<float>{2.f, -2.f, NAN, INFINITY}), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  EXPECT_THAT(read(*open(track_), 0, 2), ElementsAre(32767.f / 32768.f, -1.f, 0.f, 0.f));
}

TEST_F(ATrackOfSound, HasTheSameBytesEachTime) {
  const TempFolder other;
  record(take_, track_, 5000, {123}, 20);
  record(TakeLayout(other.path()), track_, 5000, {123}, 20);
  for (const char* name : {"mic.mka", "mic.sound.csv", "sound.json"})
    EXPECT_EQ(read_file(folder_ / name).value(), read_file(other / name).value()) << name;
}

TEST_F(ATrackOfSound, ThatIsKilledPlaysUpToTheCut) {
  constexpr std::size_t kBlocks = 40;
  ChildProcess recorder([&](const std::function<void()>& report) {
    if (!save_sound_tracks({track_}, take_)) return 3;
    const auto writer = SoundWriter::create(take_, track_);
    if (!writer) return 1;
    for (std::int64_t at = 0;; at += kSoundBlock) {
      if (!(*writer)->stamp(at, {at * 1'000'000'000 / 48'000}) ||
          !(*writer)->write(patterned(at, kSoundBlock, 2)))
        return 2;
      report();
    }
  });
  ASSERT_TRUE(recorder.wait_for_reports(kBlocks));
  recorder.kill();
  recorder.wait();
  const auto tracks = load_sound_tracks(take_);
  ASSERT_THAT(tracks, IsOkAnd(ElementsAre(track_)));
  const auto sound = open(track_);
  ASSERT_GE(sound->samples(), static_cast<std::int64_t>(kBlocks - 1) * kSoundBlock)
      << "one waits for the next";
  EXPECT_EQ(read(*sound, 0, sound->samples()), patterned(0, sound->samples(), 2));
  ASSERT_THAT(sound->clock().runs(), SizeIs(1));
  EXPECT_EQ(sound->clock().runs().front().end, sound->samples());
  EXPECT_THAT(sound->warnings(), IsEmpty()) << "no row without its sound";
}

TEST_F(ATrackOfSound, CutAnywhereOpensWithWhatIsWholeOrSaysWhyNot) {
  record(take_, track_, 3 * kSoundBlock + 10);
  const std::string whole = read_file(media()).value();
  std::int64_t most = 0;
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += bytes < 700 ? 1 : 97) {
    ASSERT_THAT(write_file(media(), whole.substr(0, bytes)), IsOk());
    const auto sound = SoundReader::open(take_, track_);
    if (!sound) {
      EXPECT_THAT(sound.error().message, HasSubstr("mic.mka"));
      continue;
    }
    const std::int64_t there = (*sound)->samples();
    EXPECT_GE(there, most);
    most = there;
    EXPECT_EQ(read(**sound, 0, there), patterned(0, there, 2));
  }
  EXPECT_EQ(most, 3 * kSoundBlock + 10);
}

TEST_F(ATrackOfSound, IsSilentWhereItIsDamagedAndSaysWhere) {
  record(take_, track_, 6 * kSoundBlock);
  std::string bytes = read_file(media()).value();
  bytes[bytes.size() / 2] ^= 0x10;
  ASSERT_THAT(write_file(media(), bytes), IsOk());
  const auto sound = open(track_);
  const auto damage = sound->damage(kGoOn);
  ASSERT_THAT(damage, IsOkAnd(ElementsAre(HasSubstr("are damaged: they are silent"))));
  const std::vector<float> now = read(*sound, 0, 6 * kSoundBlock), was = patterned(0, 6 * kSoundBlock, 2);
  int other = 0;
  for (std::size_t i = 0; i < was.size(); ++i)
    if (now[i] != was[i]) {
      EXPECT_EQ(now[i], 0.f);
      ++other;
    }
  EXPECT_GT(other, 0);
  EXPECT_LE(other, 2 * kSoundBlock) << "one block";
}

TEST_F(ATrackOfSound, OfAnotherRateOrWithoutItsFilesIsRefused) {
  record(take_, track_, 2000);
  SoundTrack other = track_;
  other.rate = 44'100;
  EXPECT_THAT(SoundReader::open(take_, other),
              FailsWith(ErrorCode::BadData, "but sound.json says 2 of 44100"));
  ASSERT_TRUE(std::filesystem::remove(folder_ / "mic.sound.csv"));
  EXPECT_THAT(SoundReader::open(take_, track_), FailsWith(ErrorCode::NotFound, "mic.sound.csv"));
  EXPECT_THAT(SoundWriter::create(take_, track_), FailsWith(ErrorCode::Io, "mic.mka"))
      << "what is there is never replaced";
}

}  // namespace
}  // namespace floatstage::capture
