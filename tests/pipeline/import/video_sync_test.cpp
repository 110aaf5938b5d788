// Videos of cameras that were started by hand, made by another program (ffmpeg).

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/import/import.h"
#include "pipeline/onset_sync.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

const std::vector<std::string> kNames = {"a", "b", "c"};
const OnsetMatch kClaps{
    .tolerance = 0.04, .separation = 0.08, .closure = 0.03, .event = "clap", .events = "claps"};

std::vector<Onset> at(const std::vector<double>& times, double later = 0) {
  std::vector<Onset> onsets;
  for (const double t : times) onsets.push_back({t + later, 1});
  return onsets;
}

TEST(ShiftsOfRecorders, AreFoundByAllOnsetsNotByTheStrongest) {
  std::vector<Onset> b = at({1, 2.3, 5.1}, 4.25);
  b.push_back({11.9, 20});  // somebody coughed into this one
  const auto shifts = shifts_of({at({1, 2.3, 5.1}), b, at({2.3, 5.1, 5.9}, -0.5)}, kNames, kClaps);
  ASSERT_THAT(shifts, IsOk());
  EXPECT_NEAR((*shifts)[1].seconds, 4.25, 1e-9);
  EXPECT_EQ((*shifts)[1].events, 3);
  EXPECT_NEAR((*shifts)[2].seconds, -0.5, 1e-9);
  EXPECT_EQ((*shifts)[0].seconds, 0);
}

TEST(ShiftsOfRecorders, AreRefusedWithTheCameraThatIsToBlame) {
  EXPECT_THAT(shifts_of({at({1}), {}, at({1})}, kNames, kClaps), FailsWith(ErrorCode::NotFound, "'b'"));
  const auto even =
      shifts_of({at({1, 2, 3, 4, 5, 6, 7, 8}), at({1, 2, 3, 4, 5, 6, 7, 8}, 0.3)}, kNames, kClaps);
  EXPECT_THAT(even, FailsWith(ErrorCode::BadData, "too much alike"));
  // c has heard one of a's claps, but where b says that there was the other.
  const auto contradicts =
      shifts_of({at({1, 2.3, 4}), at({1, 2.3, 7.7}), at({4, 7.7 + 1, 9.9})}, kNames, kClaps);
  EXPECT_THAT(contradicts, FailsWith(ErrorCode::BadData, "camera '"));
}

TEST(OnsetsInSound, AreWhereTheWaveBeginsToTheSampleInNoise) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.002F);
  std::vector<float> wave(48'000 * 3);
  for (float& s : wave) s = noise(random);
  for (const int begin : {30'000, 100'000})
    for (int i = 0; i < 2'000; ++i)
      wave[static_cast<std::size_t>(begin + i)] +=
          0.5F * std::exp(-static_cast<float>(i) / 300) * (i % 2 == 0 ? 1.0F : -1.0F);
  const std::vector<Onset> onsets = sound_onsets(wave, 48'000, 10);
  ASSERT_EQ(onsets.size(), 2u);
  EXPECT_NEAR(onsets[0].seconds, 10 + 30'000 / 48e3, 3 / 48e3);
  EXPECT_NEAR(onsets[1].seconds, 10 + 100'000 / 48e3, 3 / 48e3);
  EXPECT_TRUE(sound_onsets(std::vector<float>(48'000, 0), 48'000, 0).empty()) << "silence";
}

TEST(OnsetsInBrightness, AreWithinThePictureInWhichALightWentOn) {
  std::vector<double> times, brightness;
  for (int i = 0; i < 50; ++i) {
    times.push_back(i * 0.04);
    const double lit = std::clamp((times.back() + 0.04 - 1.05) / 0.04, 0.0, 1.0);  // on at 1.05 s
    brightness.push_back(60 + 0.3 * (i % 3) + 100 * lit);
  }
  const std::vector<Onset> onsets = brightness_onsets(brightness, times);
  ASSERT_EQ(onsets.size(), 1u);
  EXPECT_NEAR(onsets[0].seconds, 1.05, 0.002);
}

// Cameras whose pictures are a bar that grows by 40 px (of 320) a second of the scene's time, in the lower
// half; a light above it goes on and off; claps in a room with noise.
class HandStarted : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 32;
  static constexpr double kLength = 5;

  void SetUp() override {
    Rig rig = test_rig(3);
    for (RigCamera& c : rig.cameras) c.model.width = kWidth, c.model.height = kHeight;
    ASSERT_THAT(calib::write_easymocap(rig, folder_ / "in"), IsOk());
    fs::create_directories(folder_ / "in" / "videos");
    options_.calibration = {"opencv", folder_ / "in"};
    options_.pictures = folder_ / "in" / "videos";
    options_.out = folder_ / "take";
  }
  // `pictures`: words for ffmpeg behind its filter.
  void film(const std::string& camera, double begin, const std::string& rate,
            const std::vector<double>& claps, const std::vector<double>& flashes,
            const std::string& drop = "", bool sound = true) {
    std::string lit = "0", loud = "0";
    for (const double t : flashes)
      lit += text("+clip((T+", begin, "-", t, ")*", rate, "+1,0,1)*lt(T+", begin, ",", t + 0.4, ")");
    for (const double t : claps)
      loud +=
          text("+gte(t,", t - begin, ")*exp(-200*max(t-", t - begin, ",0))*sin(12000*(t-", t - begin, "))");
    const std::string lum = text("lum='if(lt(Y,", kHeight / 2, "),40+150*min(1,", lit, "),255*clip((T+",
                                 begin, ")*40-X,0,1))':cb=128:cr=128");
    std::string words = text("ffmpeg -nostdin -y -v error -f lavfi -i \"color=s=", kWidth, "x", kHeight,
                             ":r=", rate, ":d=", kLength, ",format=yuv444p,geq=", lum, drop, "\" ");
    if (sound)
      words +=
          text("-f lavfi -i \"aevalsrc='0.5*(", loud, ")+0.004*(random(0)-0.5)':s=44100:d=", kLength, "\" ");
    const Ended ended = run_command(words + "-c:v ffv1 -fps_mode passthrough -c:a aac '" +
                                    (folder_ / "in" / "videos" / camera).string() + ".mkv'");
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  // The scene's time that a picture shows, s.
  static double shown(const Image& rgb) {
    double lit = 0;
    const int y = 3 * kHeight / 4;
    for (int x = 0; x < rgb.width; ++x) lit += *rgb.at(x, y) / 255.0;
    return lit / 40;
  }
  // How far apart what the cameras show at an instant is from what their stamps say, at most, s.
  double worst_error() {
    const auto take = capture::TakeReader::open(options_.out);
    EXPECT_THAT(take, IsOk());
    double worst = 0, first = 0;
    bool any = false;
    for (int f = 0; f < (*take)->frame_count(); ++f)
      for (int c = 0; c < static_cast<int>((*take)->rig().cameras.size()); ++c) {
        const Result<Frame> frame = (*take)->frame(c, f);
        if (!frame || frame->empty()) continue;
        const double error =
            shown(*to_rgb(*frame)) - static_cast<double>(frame->info.exposure_start.ns) * 1e-9;
        if (!std::exchange(any, true)) first = error;
        worst = std::max(worst, std::abs(error - first));
      }
    return worst;
  }

  TempFolder folder_;
  ImportOptions options_;
};

TEST_F(HandStarted, AreOneTakeByTheirClapsWhateverTheirRates) {
  const std::vector<double> claps = {2.1, 2.75, 4.02};
  film("a", 0.5, "30", claps, {});
  film("b", 1.237, "25", claps, {});
  film("c", 0.031, "30", claps, {}, ",select='not(eq(mod(n,7),3))'");  // as phones do in the dark
  options_.sync = SyncSign::Clap;
  const auto report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->sync.size(), 3u);
  EXPECT_NEAR(report->sync[1].seconds, 0.5 - 1.237, 0.002);
  EXPECT_NEAR(report->sync[2].seconds, 0.5 - 0.031, 0.002);
  EXPECT_EQ(report->sync[1].events, 3);
  EXPECT_NEAR(report->frames, 25 * (kLength + 0.031 - 1.237), 3) << "while all run, at the slowest rate";
  EXPECT_LT(worst_error(), 0.006) << "s: a seventh of a picture, of which the bar is 2 ms";
  EXPECT_EQ(report->sounds, 3);
  EXPECT_THAT(report->notes, Contains(HasSubstr("began 73")));
}

TEST_F(HandStarted, AreOneTakeByAFlash) {
  film("a", 0.5, "30", {}, {2.1, 3.4});
  film("b", 1.237, "30", {}, {2.1, 3.4});
  film("c", 0.031, "30", {}, {2.1, 3.4});
  options_.sync = SyncSign::Flash;
  options_.frame_rate = 30;
  const auto report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_LT(worst_error(), 0.2 / 30) << "s: light that stays on tells when within a picture";
}

TEST_F(HandStarted, AreRefusedWhereNothingSaysWhen) {
  film("a", 0.5, "25", {2.1}, {});
  film("b", 1.2, "25", {2.1}, {});
  film("c", 0.2, "25", {}, {});
  options_.sync = SyncSign::Clap;
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::NotFound, "camera 'c': there is no clap"));
  film("c", 0.2, "25", {}, {}, "", false);
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::NotFound, "no sound track"));
  options_.sync = SyncSign::Flash;
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::NotFound, "there is no flash"));
  options_.frames.first = 5;
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::InvalidArgument, "take trim"));
  options_.frames = {};
  fs::remove(folder_ / "in" / "videos" / "c.mkv");
  fs::create_directory(folder_ / "in" / "videos" / "c");
  for (const char* name : {"1.png", "2.png"})
    ASSERT_THAT(save_png(Image(kWidth, kHeight, 3), folder_ / "in" / "videos" / "c" / name), IsOk());
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::InvalidArgument, "camera 'c': has no video"));
  EXPECT_FALSE(fs::exists(options_.out));
}

TEST_F(HandStarted, AreRefusedForAnEmptySoundTrack) {
  film("a", 0.5, "25", {2.1}, {});
  film("b", 1.2, "25", {2.1}, {});
  const Ended ended = run_command(
      text("ffmpeg -nostdin -y -v error -f lavfi -i color=s=320x32:d=2 -f lavfi -i anullsrc=r=48000:d=2 "
           "-filter:a 'aselect=0' -c:v ffv1 -c:a pcm_s16le '",
           (folder_ / "in" / "videos" / "c.mkv").string(), "'"));
  ASSERT_EQ(ended.code, 0) << ended.output;
  options_.sync = SyncSign::Clap;
  EXPECT_THAT(import_take(options_), FailsWith(ErrorCode::BadData, "--sync flash"));
  EXPECT_FALSE(fs::exists(options_.out));
}

}  // namespace
}  // namespace floatstage::pipeline
