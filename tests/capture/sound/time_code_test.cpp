#include "capture/sound/time_code.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ltc.h>

#include "tests/capture/sound/sound_support.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

TEST(ATimeCode, CountsEveryFrameOfADayThereAndBack) {
  for (const char* name : {"24", "25", "29.97", "29.97df", "30"}) {
    const TimeCodeRate rate = *time_code_rate_named(name);
    for (std::int64_t f = 0; f < 24 * 3600 * 23; f += f < 40'000 ? 1 : 1009)
      ASSERT_EQ(frames_of(code_of(f, rate), rate), f) << name << ' ' << code_of(f, rate);
  }
  const TimeCodeRate drop = *time_code_rate_named("29.97df");
  EXPECT_EQ(code_of(1799, drop), "00:00:59;29");
  EXPECT_EQ(code_of(1800, drop), "00:01:00;02");
  EXPECT_EQ(code_of(17'982, drop), "00:10:00;00");
  EXPECT_EQ(code_of(-1, *time_code_rate_named("25")), "23:59:59:24");
  for (const char* bad :
       {"", "1:00:00:00", "24:00:00:00", "00:60:00:00", "00:00:00:30", "00:01:00;00", "aa:00:00:00"})
    EXPECT_FALSE(frames_of(bad, drop)) << bad;
}

TEST(TimeCodeJson, SurvivesReadingAndWritingAndIsRefusedWhereItIsCut) {
  const TimeCode code = {*time_code_rate_named("29.97df"), 107'892, {-5}, "hand"};
  const std::string whole = to_json(code);
  EXPECT_THAT(parse_time_code(whole, "x"), IsOkAnd(code));
  for (std::size_t bytes = 0; bytes + 2 < whole.size(); ++bytes)
    EXPECT_THAT(parse_time_code(whole.substr(0, bytes), "x"), FailsWith(ErrorCode::BadData, "x"));
  std::string other = whole;
  other.replace(other.find("29.97df"), 7, "26");
  EXPECT_THAT(parse_time_code(other, "x"), FailsWith(ErrorCode::BadData, "'26' is no rate"));
}

class Ltc : public testing::Test {
 protected:
  // LTC from 01:00:00:00 on, on the second of two channels, by a clock that runs 50 ppm fast.
  std::unique_ptr<SoundReader> recorded(double hertz, LTC_TV_STANDARD standard, bool drop) {
    const SoundTrack track = {.name = "ltc", .rate = 48'000, .channels = 2, .bits = 16, .from = "test"};
    const double true_rate = 48'000 * (1 + 50e-6);
    LTCEncoder* encoder = ltc_encoder_create(true_rate, hertz, standard, 0);
    SMPTETimecode start = {};
    start.hours = 1;
    ltc_encoder_set_timecode(encoder, &start);
    if (drop) {
      LTCFrame frame;
      ltc_encoder_get_frame(encoder, &frame);
      frame.dfbit = 1;
      ltc_encoder_set_frame(encoder, &frame);
    }
    std::vector<float> levels;
    for (int f = 0; f < 1900; ++f) {
      ltc_encoder_encode_frame(encoder);
      ltcsnd_sample_t* made = nullptr;
      const int count = ltc_encoder_get_bufferptr(encoder, &made, 1);
      for (int i = 0; i < count; ++i) {
        levels.push_back(0.f);
        levels.push_back((static_cast<float>(made[i]) - 128) / 256);
      }
      ltc_encoder_inc_timecode(encoder);
    }
    ltc_encoder_free(encoder);
    const auto writer = SoundWriter::create(take_, track);
    EXPECT_THAT(writer, IsOk());
    const auto samples = static_cast<std::int64_t>(levels.size()) / 2;
    for (std::int64_t at = 0; at < samples; at += 48'000)
      EXPECT_THAT(
          (*writer)->stamp(at, {9'000'000'000 + std::llround(static_cast<double>(at) / true_rate * 1e9)}),
          IsOk());
    EXPECT_THAT((*writer)->write(levels), IsOk());
    EXPECT_THAT((*writer)->finish(), IsOk());
    return std::move(*SoundReader::open(take_, track));
  }
  TempFolder folder_;
  const TakeLayout take_{folder_.path()};
};

TEST_F(Ltc, IsReadWithItsRateAndWithoutItsClocksDrift) {
  const auto sound = recorded(25, LTC_TV_625_50, false);
  const Result<TimeCode> code = read_ltc(*sound, 1);
  ASSERT_THAT(code, IsOk());
  EXPECT_EQ(name_of(code->rate), "25");
  EXPECT_EQ(code->code_at({9'000'000'000}), "01:00:00:00");
  EXPECT_EQ(code->code_at({9'000'000'000 + 60'000'000'000}), "01:01:00:00");
  EXPECT_NEAR(static_cast<double>((code->at - Timestamp{9'000'000'000}).count) * 1e-9 -
                  static_cast<double>(code->frames - 90'000) / 25,
              0, 0.002);
  EXPECT_EQ(code->from, "ltc ltc:1");
}

TEST_F(Ltc, TellsRatesAThousandthApartAndDroppedNumbers) {
  const auto sound = recorded(30 / 1.001, LTC_TV_525_60, true);
  const Result<TimeCode> code = read_ltc(*sound, 1);
  ASSERT_THAT(code, IsOk());
  EXPECT_EQ(name_of(code->rate), "29.97df");
}

TEST_F(Ltc, OnAChannelThatHasNoneSaysSo) {
  const auto sound = recorded(24, LTC_TV_FILM_24, false);
  EXPECT_THAT(read_ltc(*sound, 0), FailsWith(ErrorCode::BadData, "no time code is heard"));
  EXPECT_THAT(read_ltc(*sound, 2), FailsWith(ErrorCode::InvalidArgument, "2 channels"));
}

}  // namespace
}  // namespace floatstage::capture
