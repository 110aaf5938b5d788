#include "capture/sound/play_out.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capture/sound/sound_support.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

class APlayOut : public testing::Test {
 protected:
  // Mono, of a clock that runs `ppm` fast: `level` of the take's time in seconds.
  template <class Level>
  std::unique_ptr<SoundReader> recorded(int rate, double seconds, double ppm, const Level& level) {
    const SoundTrack track = {.name = "mic", .rate = rate, .channels = 1, .bits = 24, .from = "test"};
    const auto writer = SoundWriter::create(take_, track);
    EXPECT_THAT(writer, IsOk());
    const double true_rate = rate * (1 + ppm * 1e-6);
    std::vector<float> second(static_cast<std::size_t>(rate));
    for (std::int64_t at = 0; at < seconds * rate; at += rate) {
      for (std::size_t i = 0; i < second.size(); ++i)
        second[i] = static_cast<float>(level((static_cast<double>(at) + static_cast<double>(i)) / true_rate));
      const Timestamp time = kBegin + Nanoseconds{std::llround(static_cast<double>(at) / true_rate * 1e9)};
      EXPECT_THAT((*writer)->stamp(at, time), IsOk());
      EXPECT_THAT((*writer)->write(second), IsOk());
    }
    EXPECT_THAT((*writer)->finish(), IsOk());
    auto reader = SoundReader::open(take_, track);
    EXPECT_THAT(reader, IsOk());
    return std::move(*reader);
  }
  static std::vector<float> heard(SoundReader& reader, Timestamp from, std::size_t samples,
                                  std::size_t piece) {
    const auto out = PlayOut::create(reader, {0});
    EXPECT_THAT(out, IsOk());
    (*out)->seek(from);
    std::vector<float> all(samples);
    for (std::size_t at = 0; at < samples; at += piece)
      EXPECT_THAT((*out)->read(std::span(all).subspan(at, std::min(piece, samples - at))), IsOk());
    return all;
  }

  static constexpr Timestamp kBegin{3'000'000'000};
  TempFolder folder_;
  const TakeLayout take_{folder_.path()};
};

TEST_F(APlayOut, IsTheRecordingItselfWhereClocksAgree) {
  const auto level = [](double t) { return 0.4 * std::sin(2 * std::numbers::pi * 440 * t); };
  const auto reader = recorded(kPlayOutRate, 2, 0, level);
  const std::vector<float> all = heard(*reader, kBegin, kPlayOutRate, 1000);
  std::vector<float> was(kPlayOutRate);
  ASSERT_THAT(reader->read(0, was), IsOk());
  EXPECT_EQ(all, was);
}

TEST_F(APlayOut, KeepsATonesPhaseThroughTenMinutesOfDrift) {
  const auto level = [](double t) { return 0.4 * std::sin(2 * std::numbers::pi * 100 * t); };
  const auto reader = recorded(8000, 600, 50, level);
  EXPECT_NEAR(reader->clock().runs()[0].ppm, 50, 0.01);
  constexpr std::size_t kLast = std::size_t{599} * kPlayOutRate;
  const std::vector<float> all = heard(*reader, kBegin, kLast, 48'000);
  double worst = 0;
  for (std::size_t i = kLast - kPlayOutRate; i + 480 < kLast; ++i)
    worst = std::max(worst, std::abs(all[i] - level(static_cast<double>(i) / kPlayOutRate)));
  // 50 ppm of ten minutes are 30 ms, three periods of this tone; 0.2 ms are an eighth of one.
  EXPECT_LT(worst, 0.4 * 2 * std::numbers::pi * 100 * 0.2e-3);
}

TEST_F(APlayOut, DoesNotDependOnTheLengthOfItsPiecesNorOnWhereItBegan) {
  const auto level = [](double t) { return 0.4 * std::sin(2 * std::numbers::pi * 440 * t); };
  const auto reader = recorded(44'100, 4, 30, level);
  const std::vector<float> once = heard(*reader, kBegin, 100'000, 100'000);
  EXPECT_EQ(heard(*reader, kBegin, 100'000, 333), once);
  const std::vector<float> later = heard(*reader, kBegin + milliseconds(1000), 1000, 1000);
  for (std::size_t i = 200; i < 900; ++i) ASSERT_NEAR(later[i], once[i + kPlayOutRate], 0.01f);
}

TEST_F(APlayOut, IsSilentWhereThereIsNoSoundAndBeginsInTime) {
  const auto reader = recorded(kPlayOutRate, 1, 0, [](double) { return 0.5; });
  const std::vector<float> all = heard(*reader, kBegin - milliseconds(500), 2 * kPlayOutRate, 777);
  EXPECT_EQ(all[kPlayOutRate / 2 - 1], 0.f);
  EXPECT_EQ(all[kPlayOutRate / 2], 0.5f);
  EXPECT_EQ(all[kPlayOutRate / 2 + kPlayOutRate - 1], 0.5f);
  EXPECT_EQ(all[kPlayOutRate / 2 + kPlayOutRate], 0.f);
}

TEST_F(APlayOut, OfAChannelThatIsNotThereIsRefused) {
  const auto reader = recorded(kPlayOutRate, 1, 0, [](double) { return 0; });
  EXPECT_THAT(PlayOut::create(*reader, {1}), FailsWith(ErrorCode::InvalidArgument, "no channel 1"));
  EXPECT_THAT(PlayOut::create(*reader, {}), FailsWith(ErrorCode::InvalidArgument, "one channel"));
}

}  // namespace
}  // namespace floatstage::capture
