#include <gtest/gtest.h>

#include "studio/node/capture_config.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"

namespace floatstage::studio {
namespace {

constexpr const char* kWhole = R"(
[studio]
frame_rate = 30
rig = "rig.json"
times = "board/times.json"
[recording]
folder = "takes"
label = "rehearsal"
codec = "raw"
queue_frames = 12
[limits]
skips = 2
duplicates = 1
spread_ms = 0.5
rate_deviation = 0.02
[[camera]]
serial = "left"
source = "v4l2:/dev/video0"
[[camera]]
serial = "right"
source = "gige:A1?rate=30"
[[sound]]
source = "alsa:hw:1"
[[sound]]
source = "tone:1000?ppm=50"
)";

Result<CaptureConfig> parsed(const std::string& toml) {
  return parse_capture_config(toml, "studio.toml", "/studio");
}

TEST(CaptureConfig, SaysEverythingThatAStudioIs) {
  const Result<CaptureConfig> config = parsed(kWhole);
  ASSERT_THAT(config, IsOk());
  EXPECT_EQ(config->frame_rate, 30);
  EXPECT_EQ(config->rig, "/studio/rig.json");
  EXPECT_EQ(config->times, "/studio/board/times.json");
  EXPECT_EQ(config->folder, "/studio/takes");
  EXPECT_EQ(config->recorder.take.label, "rehearsal");
  EXPECT_EQ(config->recorder.take.codec, capture::TakeCodec::Raw);
  EXPECT_EQ(config->recorder.take.frame_rate, 30);
  EXPECT_EQ(config->recorder.queue_frames, 12u);
  EXPECT_EQ(config->recorder.limits.skips, 2u);
  EXPECT_EQ(config->recorder.limits.duplicates, 1u);
  EXPECT_EQ(config->recorder.limits.spread_ms, 0.5);
  EXPECT_EQ(config->recorder.limits.rate_deviation, 0.02);
  ASSERT_EQ(config->cameras.size(), 2u);
  EXPECT_EQ(config->cameras[1].serial, "right");
  EXPECT_EQ(config->cameras[1].source, "gige:A1?rate=30");
  EXPECT_EQ(config->sounds, (std::vector<std::string>{"alsa:hw:1", "tone:1000?ppm=50"}));
}

TEST(CaptureConfig, HasDefaultsForAllButTheRateAndTheCameras) {
  const Result<CaptureConfig> config =
      parsed("[studio]\nframe_rate = 25\n[[camera]]\nserial = 'a'\nsource = 'v4l2:/dev/video0'\n");
  ASSERT_THAT(config, IsOk());
  EXPECT_EQ(config->recorder.take.codec, capture::TakeCodec::Ffv1);
  EXPECT_EQ(config->recorder.limits.skips, 0u);
  EXPECT_EQ(config->recorder.limits.spread_ms, 1);
  EXPECT_TRUE(config->rig.empty());
  EXPECT_TRUE(config->sounds.empty());
  EXPECT_THAT(parsed("sound = 1\n[studio]\nframe_rate = 25\n[[camera]]\nserial = 'a'\nsource = 'b'\n"),
              FailsWith(ErrorCode::BadData, "line 1: 'sound' is not understood"));
}

TEST(CaptureConfig, RefusesWhatItDoesNotUnderstandWithItsLine) {
  const struct {
    const char *from, *to, *says;
  } cases[] = {
      {"frame_rate = 30", "frame_rat = 30",
       "line 3: [studio]: 'frame_rat' is not understood; there are frame_rate, rig"},
      {"frame_rate = 30", "frame_rate = 'fast'", "line 3: [studio]: frame_rate must be a number"},
      {"frame_rate = 30", "", "frame_rate is missing"},
      {"codec = \"raw\"", "codec = \"zip\"", "codec must be ffv1, raw or h264"},
      {"skips = 2", "skips = 0.5", "skips must be a whole number"},
      {"skips = 2", "skips = -1", "skips must be a whole number from 0"},
      {"serial = \"left\"", "serial = \"a/b\"", "serial must be of letters"},
      {"serial = \"right\"", "serial = \"left\"", "serial 'left' is there twice"},
      {"source = \"v4l2:/dev/video0\"", "", "[[camera]] 1: source is missing"},
      {"[limits]", "[limit]", "'limit' is not understood; there are [studio]"},
      {"source = \"alsa:hw:1\"", "", "[[sound]] 1: source is missing, for example \"alsa:default\""},
      {"source = \"alsa:hw:1\"", "source = 1", "[[sound]] 1: source must be a text"},
      {"source = \"alsa:hw:1\"", "device = \"alsa:hw:1\"", "[[sound]] 1: source is missing"},
      {"alsa:hw:1", "tone:1000?ppm=50", "[[sound]] 2: source 'tone:1000?ppm=50' is there twice"},
      {"[[sound]]\nsource = \"alsa", "[sound]\nsource = \"alsa", "no TOML"},
      {"[studio]", "[studio", "no TOML"},
  };
  for (const auto& c : cases) {
    std::string toml = kWhole;
    toml.replace(toml.find(c.from), std::string(c.from).size(), c.to);
    EXPECT_THAT(parsed(toml), FailsWith(ErrorCode::BadData, c.says)) << c.to;
    EXPECT_THAT(parsed(toml), FailsWith(ErrorCode::BadData, "studio.toml"));
  }
  EXPECT_THAT(parsed("[studio]\nframe_rate = 25\n"), FailsWith(ErrorCode::BadData, "names no [[camera]]"));
}

TEST(CaptureConfig, SurvivesEveryTruncation) {
  const std::string whole = kWhole;
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    const Result<CaptureConfig> config = parsed(whole.substr(0, cut));
    EXPECT_TRUE(config || config.error().code == ErrorCode::BadData) << cut;
  }
}

TEST(CaptureConfig, OfTheProjectIsUnderstood) {
  const Result<CaptureConfig> config = load_capture_config(source_folder() / "config/fake-gige-8.toml");
  ASSERT_THAT(config, IsOk());
  EXPECT_EQ(config->cameras.size(), 8u);
}

}  // namespace
}  // namespace floatstage::studio
