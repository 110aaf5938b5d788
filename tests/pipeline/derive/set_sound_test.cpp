#include "pipeline/derive/set_sound.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ltc.h>

#include "capture/sound/sound_writer.h"
#include "capture/take_check.h"
#include "core/file.h"
#include "pipeline/derive/foreign_sound.h"
#include "pipeline/derive/sound_claps.h"
#include "pipeline/film_sound.h"
#include "pipeline/recorded_take.h"
#include "tests/pipeline/derive/sound_files.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kFps = 25, kRate = 48'000, kOwnRate = 8'000;
constexpr double kSeconds = 100;
const Timestamp kBegin{7'000'000'000};
// When hands clap, s after the first picture: at uneven distances.
const std::vector<double> kClaps = {3.02, 11.1, 24.34, 41.9, 60.5, 77.06, 93.3};

/// A clap as a microphone hears it: a burst that is over after 20 ms, before a hiss of 60 dB less.
std::vector<float> clapping(double seconds, int rate, const std::vector<double>& claps,
                            double loudness = 0.8) {
  std::mt19937 seed(7);
  std::normal_distribution<float> noise(0.f, 1.f);
  std::vector<float> out(static_cast<std::size_t>(seconds * rate));
  for (float& level : out) level = 2e-4f * noise(seed);
  for (const double at : claps)
    for (int i = 0; i < rate / 50; ++i) {
      const auto sample = static_cast<std::size_t>(std::lround(at * rate)) + static_cast<std::size_t>(i);
      if (sample >= out.size()) continue;
      const double fall = std::exp(-i / (0.003 * rate));
      out[sample] += static_cast<float>(loudness * fall) * (i == 0 ? 1.f : 0.5f * noise(seed));
    }
  return out;
}

/// Hands that clap, seen as a white picture, and heard by a camera's microphone where `heard`.
void record_take(const fs::path& folder, bool heard) {
  capture::TakeWriterOptions options;
  options.codec = capture::TakeCodec::Raw;
  options.frame_rate = kFps;
  const auto writer = capture::TakeWriter::create(folder, test_rig(1), options);
  ASSERT_THAT(writer, IsOk());
  Image picture(kImportWidth, kImportHeight, 3);
  for (int f = 0; f < static_cast<int>(kSeconds * kFps); ++f) {
    const double from = static_cast<double>(f) / kFps;
    const bool flash = std::any_of(kClaps.begin(), kClaps.end(), [&](double c) {
      return c >= from - 1e-9 && c < from + 1.0 / kFps - 1e-9;
    });
    std::fill(picture.pixels.begin(), picture.pixels.end(), flash ? 255 : 20);
    FrameInfo info;
    info.camera = 0;
    info.sequence = static_cast<std::uint64_t>(f);
    info.exposure_start = kBegin + Nanoseconds{std::llround(from * 1e9)};
    ASSERT_THAT((*writer)->write(make_frame(info, picture)), IsOk());
  }
  if (heard) {
    const capture::SoundTrack track = {
        .name = "cam", .rate = kOwnRate, .channels = 1, .bits = 16, .from = "test"};
    ASSERT_THAT(capture::save_sound_tracks({track}, TakeLayout(folder)), IsOk());
    const auto sound = capture::SoundWriter::create(TakeLayout(folder), track);
    ASSERT_THAT(sound, IsOk());
    // Its clock runs 20 ppm slow.
    const double true_rate = kOwnRate * (1 - 20e-6);
    std::vector<double> claps;
    for (const double c : kClaps) claps.push_back(c * true_rate / kOwnRate);
    const std::vector<float> levels = clapping(kSeconds, kOwnRate, claps, 0.3);
    for (std::int64_t at = 0; at < static_cast<std::int64_t>(levels.size()); at += kOwnRate)
      ASSERT_THAT(
          (*sound)->stamp(at, kBegin + Nanoseconds{std::llround(static_cast<double>(at) / true_rate * 1e9)}),
          IsOk());
    ASSERT_THAT((*sound)->write(levels), IsOk());
    ASSERT_THAT((*sound)->finish(), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());
  ASSERT_THAT(seal_take(folder, nullptr), IsOk());
}

class SetSound : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    takes_ = new TempFolder;
    record_take(*takes_ / "heard", true);
    record_take(*takes_ / "mute", false);
    // The same with time code: 10:00:00:00 at the first picture.
    const auto take = capture::TakeReader::open(*takes_ / "mute");
    ASSERT_THAT(take, IsOk());
    ASSERT_THAT(derive_take(**take,
                            {.rig = std::nullopt,
                             .how = "set-time-code",
                             .label = "",
                             .time_code = capture::TimeCode{{25, false, false}, 900'000, kBegin, "hand"}},
                            *takes_ / "coded"),
                IsOk());
  }
  static void TearDownTestSuite() {
    delete takes_;
    takes_ = nullptr;
  }

  /// What another recorder heard that began `late` seconds after the first picture, by a clock that runs
  /// `ppm` fast.
  static std::vector<float> other(double late, double ppm, double seconds = kSeconds - 10) {
    std::vector<double> claps;
    for (const double c : kClaps)
      if (c > late) claps.push_back((c - late) * (1 + ppm * 1e-6));
    return clapping(seconds, kRate, claps);
  }

  Result<SetSoundReport> set(const char* take, const std::string& bytes, const SoundPlace& place,
                             const std::string& file = "rec.wav") {
    SetSoundOptions options;
    options.take = *takes_ / take;
    options.file = folder_.write(file, bytes);
    options.out = folder_ / "out";
    options.place = place;
    return set_sound(options);
  }

  /// How far from the flashes the new take's film clicks, at most; s.
  double farthest(int expected) {
    const auto take = capture::TakeReader::open(folder_ / "out");
    EXPECT_THAT(take, IsOk());
    if (!take) return 1e9;
    std::vector<int> frames;
    for (int f = 0; f < (*take)->frame_count(); ++f) frames.push_back(f);
    const auto sounds = FilmSounds::open(**take, frames, kFps, "");
    EXPECT_THAT(sounds, IsOk());
    std::vector<float> levels(static_cast<std::size_t>((*sounds)->sound().samples));
    EXPECT_THAT((*sounds)->sound().read(0, levels), IsOk());
    double farthest = 0, last = -1;
    int clicks = 0;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const double t = static_cast<double>(i) / capture::kPlayOutRate;
      if (std::abs(levels[i]) < 0.2f || t < last + 0.2) continue;
      last = t, ++clicks;
      double nearest = 1e9;
      for (const double c : kClaps) nearest = std::min(nearest, std::abs(c - t));
      farthest = std::max(farthest, nearest);
    }
    EXPECT_EQ(clicks, expected);
    return farthest;
  }

  void expect_nothing_made() const {
    for (const std::string& name : folder_.names()) EXPECT_EQ(name.substr(0, 3), "rec") << name;
  }

  static TempFolder* takes_;
  TempFolder folder_;
};
TempFolder* SetSound::takes_ = nullptr;

TEST_F(SetSound, IsHeardFromWhereItIsSaidToBegin) {
  const auto report = set("mute", wav_file(other(2.5, 0), 1, kRate), SoundAt{2.5});
  ASSERT_THAT(report, IsOk());
  EXPECT_NEAR(report->begins, 2.5, 1e-6);
  EXPECT_EQ(report->track.name, "rec");
  EXPECT_LT(farthest(6), 0.001) << "it ends before the last";
}

TEST_F(SetSound, MayBeginBeforeThePicturesAndEndAfterThem) {
  const auto report = set("mute", wav_file(other(-4, 0, kSeconds + 10), 1, kRate), SoundAt{-4});
  ASSERT_THAT(report, IsOk());
  EXPECT_LT(farthest(7), 0.001);
}

TEST_F(SetSound, SealsWhatItAddsAndLeavesTheOldTakeAlone) {
  const auto report = set("heard", wav_file(other(2.5, 0), 1, kRate), SoundAt{2.5});
  ASSERT_THAT(report, IsOk());
  for (const fs::path& take : {*takes_ / "heard", folder_ / "out"}) {
    const auto check = check_take(take, nullptr);
    ASSERT_THAT(check, IsOk());
    EXPECT_TRUE(check->sealed);
    EXPECT_THAT(check->problems, testing::IsEmpty()) << take;
  }
  const auto tracks = capture::load_sound_tracks(TakeLayout(folder_ / "out"));
  ASSERT_THAT(tracks, IsOk());
  ASSERT_EQ(tracks->size(), 2u);
  EXPECT_EQ(tracks->front().name, "rec") << "what is set is what is heard";
  EXPECT_EQ(tracks->back().name, "cam");
  EXPECT_THAT(folder_.names(), ElementsAre("out", "rec.wav")) << "nothing else is left";
  // A bit of what was added is as good as any other.
  std::string samples = *read_file(folder_ / "out/rec.mka");
  samples[samples.size() / 2] ^= 1;
  ASSERT_THAT(write_file(folder_ / "out/rec.mka", samples), IsOk());
  EXPECT_THAT(check_take(folder_ / "out", nullptr)->problems, testing::Contains(HasSubstr("rec.mka")));
}

// Both clocks are their own: the camera's runs 20 ppm slow, the recorder's 50 ppm fast.
TEST_F(SetSound, MeetsTheTakesOwnClapsAndTheirClocksTheWholeTakeLong) {
  const auto report = set("heard", wav_file(other(4.2, 50), 1, kRate), SoundByClap{});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->signs, 6) << "the first was before it began";
  EXPECT_NEAR(report->begins, 4.2, 5e-4);
  EXPECT_NEAR(report->ppm, 50, 5);
  EXPECT_LT(report->spread, 5e-4);
  EXPECT_LT(farthest(6), 0.001);
}

TEST_F(SetSound, MeetsFlashesInThePicturesWhereTheTakeHasNoSound) {
  const auto report = set("mute", wav_file(other(4.2, 0), 1, kRate), SoundByClap{.flash = true});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->signs, 6);
  EXPECT_NEAR(report->begins, 4.2, 0.5 / kFps) << "a flash is known to half a picture";
  EXPECT_LT(farthest(6), 0.5 / kFps);
}

TEST_F(SetSound, IsPlacedByOneClapAlone) {
  const auto report = set("mute", wav_file(other(80, 0, 15), 1, kRate), SoundByClap{.flash = true});
  EXPECT_THAT(report, FailsWith(ErrorCode::BadData, "too few or too much alike"))
      << "one clap may be any of seven flashes";
  expect_nothing_made();
}

TEST_F(SetSound, TakesNoNoiseForAClap) {
  // It begins in the middle of applause, which goes on for a second; later somebody claps.
  std::vector<float> levels = other(4.2, 0);
  std::mt19937 seed(3);
  std::normal_distribution<float> noise(0.f, 0.3f);
  for (int i = 0; i < kRate; ++i) levels[static_cast<std::size_t>(i)] = noise(seed);
  // And a motor that is switched on, and runs.
  for (int i = 30 * kRate; i < 33 * kRate; ++i) levels[static_cast<std::size_t>(i)] += 0.3f * noise(seed);
  const auto report = set("heard", wav_file(levels, 1, kRate), SoundByClap{});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->signs, 6);
  EXPECT_NEAR(report->begins, 4.2, 5e-4);

  std::vector<float> applause(static_cast<std::size_t>(20 * kRate));
  for (float& level : applause) level = noise(seed);
  fs::remove_all(folder_ / "out");
  EXPECT_THAT(set("heard", wav_file(applause, 1, kRate), SoundByClap{}),
              FailsWith(ErrorCode::NotFound, "rec.wav: there is no clap in it"));
  expect_nothing_made();
}

TEST_F(SetSound, FollowsTheFilesOwnStamp) {
  const std::int64_t ten_hours = 36'000ll * kRate;
  const auto report =
      set("coded", wav_file(other(4.2, 0), 1, kRate, ten_hours + std::lround(4.2 * kRate)), SoundByStamp{});
  ASSERT_THAT(report, IsOk());
  EXPECT_NEAR(report->begins, 4.2, 1e-4);
  EXPECT_LT(farthest(6), 0.001);
  fs::remove_all(folder_ / "out");
  EXPECT_THAT(set("coded", wav_file(other(4.2, 0), 1, kRate), SoundByStamp{}),
              FailsWith(ErrorCode::NotFound, "rec.wav: does not say when it was recorded"));
  EXPECT_THAT(set("mute", wav_file(other(4.2, 0), 1, kRate, ten_hours), SoundByStamp{}),
              FailsWith(ErrorCode::InvalidArgument, "has no time code"));
  EXPECT_THAT(set("coded", wav_file(other(4.2, 0), 1, kRate, 2 * ten_hours), SoundByStamp{}),
              FailsWith(ErrorCode::InvalidArgument, "nothing of it is heard"));
  expect_nothing_made();
}

TEST_F(SetSound, FollowsATimeCodeThatIsSaid) {
  const auto report = set("coded", wav_file(other(4.2, 0), 1, kRate), SoundAtCode{"10:00:04:05"});
  ASSERT_THAT(report, IsOk());
  EXPECT_NEAR(report->begins, 4.2, 1e-6);
  fs::remove_all(folder_ / "out");
  EXPECT_THAT(set("coded", wav_file(other(4.2, 0), 1, kRate), SoundAtCode{"10:00:04:25"}),
              FailsWith(ErrorCode::InvalidArgument, "'10:00:04:25' is no time code of 25 frames a second"));
}

/// LTC of 25 frames a second from 10:00:00:00 + `late` on, in the channel after the sound's.
std::vector<float> beside_ltc(const std::vector<float>& sound, double late, double ppm, double hertz = 25) {
  LTCEncoder* encoder = ltc_encoder_create(kRate * (1 + ppm * 1e-6), hertz, LTC_TV_625_50, 0);
  SMPTETimecode start = {};
  start.hours = 10;
  start.secs = static_cast<unsigned char>(late);
  start.frame = static_cast<unsigned char>(std::lround((late - std::floor(late)) * 25));
  ltc_encoder_set_timecode(encoder, &start);
  std::vector<float> code;
  while (code.size() < sound.size()) {
    ltc_encoder_encode_frame(encoder);
    ltcsnd_sample_t* made = nullptr;
    const int count = ltc_encoder_get_bufferptr(encoder, &made, 1);
    for (int i = 0; i < count; ++i) code.push_back((static_cast<float>(made[i]) - 128.f) / 128.f);
    ltc_encoder_inc_timecode(encoder);
  }
  ltc_encoder_free(encoder);
  std::vector<float> out;
  for (std::size_t i = 0; i < sound.size(); ++i) out.push_back(sound[i]), out.push_back(code[i]);
  return out;
}

TEST_F(SetSound, FollowsTimeCodeOnOneOfItsChannelsWhichIsNotHeard) {
  const std::vector<float> both = beside_ltc(other(4.2, 50), 4.2, 50);
  const auto report = set("coded", wav_file(both, 2, kRate), SoundByLtc{1});
  ASSERT_THAT(report, IsOk());
  EXPECT_GT(report->signs, 2000);
  EXPECT_NEAR(report->begins, 4.2, 1e-3);
  EXPECT_NEAR(report->ppm, 50, 2);
  EXPECT_EQ(report->track.channels, 1);
  EXPECT_LT(farthest(6), 0.001);
  fs::remove_all(folder_ / "out");
  EXPECT_THAT(set("coded", wav_file(both, 2, kRate), SoundByLtc{0}),
              FailsWith(ErrorCode::BadData, "rec.wav, channel 0: no time code is heard"));
  EXPECT_THAT(set("coded", wav_file(both, 2, kRate), SoundByLtc{2}),
              FailsWith(ErrorCode::InvalidArgument, "has no channel 2"));
  EXPECT_THAT(set("coded", wav_file(other(4.2, 50), 1, kRate), SoundByLtc{0}),
              FailsWith(ErrorCode::InvalidArgument, "nothing is left to hear"));
  EXPECT_THAT(set("coded", wav_file(beside_ltc(other(4.2, 0), 4.2, 0, 24), 2, kRate), SoundByLtc{1}),
              FailsWith(ErrorCode::BadData, "its LTC has 24 frames a second, the take's time code 25"));
  expect_nothing_made();
}

TEST_F(SetSound, RefusesWhatIsNoSound) {
  const auto refused = [&](const std::string& bytes, ErrorCode code, const std::string& why) {
    EXPECT_THAT(set("mute", bytes, SoundAt{0}), FailsWith(code, why));
    expect_nothing_made();
  };
  refused("", ErrorCode::BadData, "rec.wav");
  refused(wav_file({}, 1, kRate), ErrorCode::BadData, "rec.wav");
  refused("no sound at all", ErrorCode::BadData, "rec.wav");
  refused(wav_file(std::vector<float>(kRate, 0.f), 1, kRate), ErrorCode::BadData, "holds silence only");
  SetSoundOptions options;
  options.take = *takes_ / "mute";
  options.file = folder_ / "none.wav";
  options.out = folder_ / "out";
  EXPECT_THAT(set_sound(options), FailsWith(ErrorCode::NotFound, "none.wav"));
  options.file = folder_.write("rec.png", "");
  ASSERT_THAT(write_file(options.file, *read_file(*takes_ / "mute/take.json")), IsOk());
  EXPECT_THAT(set_sound(options), FailsWith(ErrorCode::BadData, "rec.png"));
  auto film = capture::TakeReader::open(*takes_ / "mute");
  ASSERT_THAT(film, IsOk());
  options.file = (*takes_ / "mute") / (*film)->manifest().cameras.front().media;
  options.name = "film";
  EXPECT_THAT(set_sound(options), FailsWith(ErrorCode::BadData, "has no sound track"));
  options.file = folder_.write("rec.wav", wav_file(other(0, 0, 2), 1, kRate));
  options.name = "a";  // the camera's
  EXPECT_THAT(set_sound(options), FailsWith(ErrorCode::InvalidArgument, "a track or a camera 'a' already"));
  options.name = "no name";
  EXPECT_THAT(set_sound(options), FailsWith(ErrorCode::InvalidArgument, "'no name' is no name"));
  expect_nothing_made();
  ASSERT_THAT(set("mute", wav_file(other(2.5, 0), 1, kRate), SoundAt{2.5}), IsOk());
  EXPECT_THAT(set("mute", wav_file(other(2.5, 0), 1, kRate), SoundAt{2.5}),
              FailsWith(ErrorCode::AlreadyExists, "out"));
}

TEST_F(SetSound, RefusesAFileThatIsCutOffAnywhere) {
  const std::string whole = wav_file(clapping(0.01, kRate, {}, 0.5), 1, kRate, 12);
  for (std::size_t bytes = 0; bytes < whole.size(); bytes += bytes < 700 ? 13 : 101) {
    EXPECT_THAT(set("mute", whole.substr(0, bytes), SoundAt{0}), FailsWith(ErrorCode::BadData, "rec.wav"))
        << bytes;
    expect_nothing_made();
  }
  EXPECT_THAT(set("mute", whole + std::string(9'000, '\0'), SoundAt{0}),
              FailsWith(ErrorCode::BadData, "rec.wav: holds more than 1000 chunks"));
  EXPECT_THAT(set("mute", whole.substr(0, whole.size() - 2), SoundAt{0}),
              FailsWith(ErrorCode::BadData, "is cut off: it states 960 bytes of sound and holds 958"));
}

TEST(ClapsInASound, BeginOutOfQuietToTheSample) {
  const TempFolder folder;
  const TakeLayout take(folder.path());
  const capture::SoundTrack track = {.name = "x", .rate = kRate, .channels = 1, .bits = 24, .from = ""};
  ASSERT_THAT(capture::save_sound_tracks({track}, take), IsOk());
  const auto writer = capture::SoundWriter::create(take, track);
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->stamp(0, kBegin), IsOk());
  // The second is 100 ms after the first: not out of quiet, but its echo.
  ASSERT_THAT((*writer)->write(clapping(8, kRate, {0.1, 1.5, 1.6, 6.25})), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  const auto sound = capture::SoundReader::open(take, track);
  ASSERT_THAT(sound, IsOk());
  const auto claps = claps_in(**sound, nullptr);
  ASSERT_THAT(claps, IsOk());
  ASSERT_EQ(claps->size(), 2u) << "what is loud at 0.1 s has too little before it";
  EXPECT_NEAR(static_cast<double>((*claps)[0].sample), 1.5 * kRate, 2);
  EXPECT_NEAR(static_cast<double>((*claps)[1].sample), 6.25 * kRate, 2);
}

}  // namespace
}  // namespace floatstage::pipeline
