#include "pipeline/film_sound.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sound/sound_writer.h"
#include "capture/take_check.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/derive/join.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/recorded_take.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using capture::kPlayOutRate;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kFps = 25, kSoundRate = 8'000;
constexpr std::uint8_t kWhite = 255;

/// A take whose pictures are white, and whose sound clicks, at every `clap` seconds.
struct Clapped {
  double seconds = 10, clap = 2;
  double picture_ppm = 0, sound_ppm = 0;  // that their clocks run fast
  Timestamp begin{7'000'000'000};
};

void record(const fs::path& folder, const Clapped& c) {
  const Rig rig = test_rig(1);
  capture::TakeWriterOptions options;
  options.codec = capture::TakeCodec::Raw;
  options.frame_rate = kFps;
  const auto writer = capture::TakeWriter::create(folder, rig, options);
  ASSERT_THAT(writer, IsOk());
  const auto frames = static_cast<int>(c.seconds * kFps);
  const double period = 1 / (kFps * (1 + c.picture_ppm * 1e-6));
  Image picture(kImportWidth, kImportHeight, 3);
  for (int f = 0; f < frames; ++f) {
    // The flash is in the picture whose exposure it falls into.
    const double from = f * period, clap = std::ceil(from / c.clap - 1e-9) * c.clap;
    std::fill(picture.pixels.begin(), picture.pixels.end(), clap < from + period - 1e-9 ? kWhite : 0);
    FrameInfo info;
    info.camera = 0;
    info.sequence = static_cast<std::uint64_t>(f);
    info.exposure_start = c.begin + Nanoseconds{std::llround(from * 1e9)};
    ASSERT_THAT((*writer)->write(make_frame(info, picture)), IsOk());
  }
  const capture::SoundTrack track = {
      .name = "mic", .rate = kSoundRate, .channels = 1, .bits = 16, .from = "test"};
  const TakeLayout take(folder);
  ASSERT_THAT(capture::save_sound_tracks({track}, take), IsOk());
  const auto sound = capture::SoundWriter::create(take, track);
  ASSERT_THAT(sound, IsOk());
  const double rate = kSoundRate * (1 + c.sound_ppm * 1e-6);
  std::vector<float> second(kSoundRate);
  for (std::int64_t at = 0; at < c.seconds * kSoundRate; at += kSoundRate) {
    for (std::size_t i = 0; i < second.size(); ++i) {
      const double from = (static_cast<double>(at) + static_cast<double>(i)) / rate;
      const double clap = std::ceil(from / c.clap - 1e-9) * c.clap;
      second[i] = clap < from + 1 / rate - 1e-9 ? 0.9f : 0.f;
    }
    const Timestamp time = c.begin + Nanoseconds{std::llround(static_cast<double>(at) / rate * 1e9)};
    ASSERT_THAT((*sound)->stamp(at, time), IsOk());
    ASSERT_THAT((*sound)->write(second), IsOk());
  }
  ASSERT_THAT((*sound)->finish(), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  ASSERT_THAT(seal_take(folder, nullptr), IsOk());
}

std::unique_ptr<capture::TakeReader> opened(const fs::path& folder) {
  auto take = capture::TakeReader::open(folder);
  EXPECT_THAT(take, IsOk());
  return std::move(*take);
}

std::vector<int> counted(int first, int end, int step = 1) {
  std::vector<int> out;
  for (int i = first; i < end; i += step) out.push_back(i);
  return out;
}

bool is_white(capture::TakeReader& take, int frame) {
  const auto rgb = to_rgb(*take.frame(0, frame));
  return rgb && rgb->pixels[0] == kWhite;
}

// Seconds of the film at which it clicks.
std::vector<double> clicks_in(const capture::TakeReader& take, const std::vector<int>& frames, double fps) {
  const auto sounds = FilmSounds::open(take, frames, fps, "");
  EXPECT_THAT(sounds, IsOk());
  std::vector<double> out;
  if (!*sounds) return out;
  std::vector<float> levels(kPlayOutRate);
  for (std::int64_t at = 0; at < (*sounds)->sound().samples; at += kPlayOutRate) {
    EXPECT_THAT((*sounds)->sound().read(at, levels), IsOk());
    for (std::size_t i = 0; i < levels.size(); ++i)
      if (const double t = (static_cast<double>(at) + static_cast<double>(i)) / kPlayOutRate;
          levels[i] > 0.3f && (out.empty() || t > out.back() + 0.1))
        out.push_back(t);
  }
  return out;
}

class AClap : public testing::Test {
 protected:
  TempFolder folder_;
};

// The issue's own: ten minutes, 50 ppm, 5 ms. Picture p of the film is shown from p / fps on, and the clap
// fell into its exposure: a click belongs between that and one picture later.
TEST_F(AClap, IsSeenAndHeardTogetherThroughTenMinutesOfDrift) {
  record(folder_ / "take", {.seconds = 600, .clap = 60, .sound_ppm = 50});
  const auto take = opened(folder_ / "take");
  const std::vector<int> frames = counted(0, take->frame_count());
  const std::vector<double> clicks = clicks_in(*take, frames, kFps);
  int white = 0;
  double worst = 0;
  for (int f = 0; f < take->frame_count(); ++f) {
    if (!is_white(*take, f)) continue;
    if (f > 0) {
      const auto click = static_cast<std::size_t>(white - 1);  // the one at 0 fades in
      ASSERT_LT(click, clicks.size());
      EXPECT_NEAR(clicks[click], static_cast<double>(f) / kFps, 0.005) << "frame " << f;
      worst = std::max(worst, std::abs(clicks[click] - static_cast<double>(f) / kFps));
    }
    ++white;
  }
  EXPECT_EQ(white, 10);
  std::printf("flashes and clicks are %.3f ms apart at most\n", 1e3 * worst);
}

TEST_F(AClap, IsTogetherWhereThePicturesClockDriftsToo) {
  record(folder_ / "take", {.seconds = 300, .clap = 60, .picture_ppm = -80, .sound_ppm = 70});
  const auto take = opened(folder_ / "take");
  const std::vector<double> clicks = clicks_in(*take, counted(0, take->frame_count()), kFps);
  ASSERT_GE(clicks.size(), 4u);
  // The film shows every picture for 1 / 25 s, whatever the camera took.
  EXPECT_NEAR(clicks.back(), 240 * (1 - 80e-6), 0.005);
}

TEST_F(AClap, IsHeardInAFilmOfAnotherRateAndInAPartOfTheTake) {
  record(folder_ / "take", {});
  const auto take = opened(folder_ / "take");
  std::vector<int> at30;
  for (int p = 0; p < 300; ++p) at30.push_back(std::min(p * kFps / 30, 249));
  const std::vector<double> clicks = clicks_in(*take, at30, 30);
  ASSERT_THAT(clicks, SizeIs(4));  // the one at 0 fades in
  for (std::size_t i = 0; i < clicks.size(); ++i)
    EXPECT_NEAR(clicks[i], 2.0 * static_cast<double>(i + 1), 0.005);
  const std::vector<double> part = clicks_in(*take, counted(40, 60), kFps);
  ASSERT_THAT(part, SizeIs(1));
  EXPECT_NEAR(part[0], 10.0 / kFps, 0.001);
}

TEST_F(AClap, IsNotHeardWhereTheTakeStandsStillOrIsSlowOrFast) {
  record(folder_ / "take", {});
  const auto take = opened(folder_ / "take");
  EXPECT_THAT(sound_cuts(*take, std::vector<int>(100, 50), kFps), IsEmpty());
  std::vector<int> slow;
  for (int p = 0; p < 200; ++p) slow.push_back(p / 2);
  EXPECT_THAT(sound_cuts(*take, slow, kFps), IsEmpty());
  EXPECT_THAT(sound_cuts(*take, counted(0, 200, 2), kFps), IsEmpty());
  EXPECT_THAT(sound_cuts(*take, counted(0, 200, 3), kFps), IsEmpty());
  std::vector<int> backwards = counted(0, 200);
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_THAT(sound_cuts(*take, backwards, kFps), IsEmpty());

  // Bullet time: it plays, stands still for two seconds, and plays on.
  std::vector<int> frozen = counted(0, 60);
  frozen.insert(frozen.end(), 50, 60);
  for (const int f : counted(60, 200)) frozen.push_back(f);
  const std::vector<SoundCut> cuts = sound_cuts(*take, frozen, kFps);
  ASSERT_THAT(cuts, SizeIs(2));
  EXPECT_NEAR(static_cast<double>(cuts[0].end) / kPlayOutRate, 60.0 / kFps, 0.1);
  EXPECT_NEAR(static_cast<double>(cuts[1].first) / kPlayOutRate, 110.0 / kFps, 0.1);
}

TEST_F(AClap, IsHeardInEachTurnOfAFilmThatBeginsAgain) {
  record(folder_ / "take", {});
  const auto take = opened(folder_ / "take");
  std::vector<int> twice = counted(40, 90);
  for (const int f : counted(40, 90)) twice.push_back(f);
  const std::vector<double> clicks = clicks_in(*take, twice, kFps);
  ASSERT_THAT(clicks, SizeIs(2));
  EXPECT_NEAR(clicks[1] - clicks[0], 2, 0.001);
}

TEST_F(AClap, StaysTogetherInTakesMadeFromTakes) {
  record(folder_ / "a", {.sound_ppm = 40});
  record(folder_ / "b", {.sound_ppm = -20, .begin = {500'000'000'000}});
  const auto a = opened(folder_ / "a");
  ASSERT_THAT(derive_take(*a, {.rig = std::nullopt, .first = 40, .end = 160, .how = "trim", .label = ""},
                          folder_ / "part"),
              IsOk());
  const auto part = opened(folder_ / "part");
  const std::vector<double> in_part = clicks_in(*part, counted(0, 120), kFps);
  ASSERT_THAT(in_part, SizeIs(3));
  EXPECT_NEAR(in_part[0], 10.0 / kFps, 0.001);

  ASSERT_THAT(join_takes({folder_ / "part", folder_ / "b"}, folder_ / "both", nullptr), IsOk());
  const auto both = opened(folder_ / "both");
  const std::vector<double> clicks = clicks_in(*both, counted(0, both->frame_count()), kFps);
  std::vector<double> flashes;
  for (int f = 0; f < both->frame_count(); ++f)
    if (is_white(*both, f) && f != 120) flashes.push_back(static_cast<double>(f) / kFps);  // 120 fades in
  ASSERT_EQ(clicks.size(), flashes.size());
  for (std::size_t i = 0; i < clicks.size(); ++i) EXPECT_NEAR(clicks[i], flashes[i], 0.002);
  for (const char* take : {"part", "both"}) {
    const auto check = capture::check_take(folder_ / take, [](std::uint64_t) { return true; });
    ASSERT_THAT(check, IsOk());
    EXPECT_TRUE(check->sealed);
    EXPECT_THAT(check->problems, IsEmpty()) << take;
  }
  const auto facts = sounds_of(*part);
  ASSERT_THAT(facts, IsOkAnd(SizeIs(1)));
  EXPECT_NEAR(facts->front().ppm, 40, 0.1);
  EXPECT_NEAR(facts->front().begins, -1.6, 1e-3);
}

TEST_F(AClap, OfATrimmedTakeHasItsOwnTimeCode) {
  record(folder_ / "take", {});
  const auto take = opened(folder_ / "take");
  const capture::TimeCode code = {*capture::time_code_rate_named("25"), 900'000, *begin_of(*take), "hand"};
  ASSERT_THAT(
      derive_take(*take, {.rig = std::nullopt, .how = "set-time-code", .label = "", .time_code = code},
                  folder_ / "coded"),
      IsOk());
  ASSERT_THAT(derive_take(*opened(folder_ / "coded"),
                          {.rig = std::nullopt, .first = 40, .end = 160, .how = "trim", .label = ""},
                          folder_ / "part"),
              IsOk());
  const auto part = opened(folder_ / "part");
  const auto own = capture::load_time_code(part->layout());
  ASSERT_THAT(own, IsOk());
  ASSERT_TRUE(*own);
  EXPECT_EQ((*own)->code_at(*begin_of(*part)), "10:00:01:15");

  // The channel that it is read from is not heard.
  EXPECT_THAT(clicks_in(*part, counted(0, 120), kFps), SizeIs(3));
  capture::TimeCode ltc = code;
  ltc.from = "ltc mic:0";
  ASSERT_THAT(capture::save_time_code(ltc, part->layout()), IsOk());
  EXPECT_THAT(clicks_in(*part, counted(0, 120), kFps), IsEmpty());
}

TEST_F(AClap, WhoseSoundIsChangedOrLostIsFoundByVerify) {
  record(folder_ / "take", {});
  const auto problems = [&] {
    const auto check = capture::check_take(folder_ / "take", [](std::uint64_t) { return true; });
    return check ? check->problems : std::vector<std::string>();
  };
  ASSERT_THAT(problems(), IsEmpty());
  fs::rename(folder_ / "take" / "mic.mka", folder_ / "away");
  EXPECT_THAT(problems(), testing::Contains(testing::HasSubstr("mic.mka is missing")));
  fs::rename(folder_ / "away", folder_ / "take" / "mic.mka");
  ASSERT_THAT(problems(), IsEmpty());
  fs::resize_file(folder_ / "take" / "mic.sound.csv", 40);
  EXPECT_THAT(problems(), testing::Contains(testing::HasSubstr("mic.sound.csv has 40 bytes")));
}

TEST_F(AClap, OfATrackThatIsNotThereIsAskedForInVain) {
  record(folder_ / "take", {});
  const auto take = opened(folder_ / "take");
  EXPECT_THAT(FilmSounds::open(*take, counted(0, 100), kFps, "boom"),
              FailsWith(ErrorCode::NotFound, "no sound 'boom'; it has mic"));
}

}  // namespace
}  // namespace floatstage::pipeline
