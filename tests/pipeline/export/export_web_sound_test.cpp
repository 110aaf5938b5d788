// The sound of `export web`, in a headless Chromium, from file://: what is seen and what is heard are of one
// time.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "capture/sound/media_sound.h"
#include "capture/sound/sound_writer.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "pipeline/export/export_web.h"
#include "pipeline/export/web_frame.h"
#include "tests/pipeline/export/folder_server.h"
#include "tests/pipeline/export/processed_take.h"
#include "tests/support/browser.h"
#include "tests/support/run_command.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Each;
using testing::EndsWith;
using testing::StartsWith;

constexpr int kFrames = 40, kRate = 25, kSoundRate = 48'000, kClickEach = 10;  // frames
constexpr double kLength = double(kFrames) / kRate;

// A sound that clicks where every tenth frame begins.
void add_sound(const fs::path& folder) {
  const auto take = capture::TakeReader::open(folder);
  ASSERT_THAT(take, IsOk());
  const Timestamp begin = (*take)->rows(0).front().info.exposure_start;
  const capture::SoundTrack track = {
      .name = "mic", .rate = kSoundRate, .channels = 1, .bits = 16, .from = "test"};
  ASSERT_THAT(capture::save_sound_tracks({track}, (*take)->layout()), IsOk());
  const auto sound = capture::SoundWriter::create((*take)->layout(), track);
  ASSERT_THAT(sound, IsOk());
  std::vector<float> samples(static_cast<std::size_t>(kSoundRate * (kLength + 0.4)));
  constexpr std::size_t kApart = kSoundRate / kRate * kClickEach;
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = i % kApart < 48 ? 0.9f : 0.f;
  ASSERT_THAT((*sound)->stamp(0, begin), IsOk());
  ASSERT_THAT((*sound)->write(samples), IsOk());
  ASSERT_THAT((*sound)->stamp(static_cast<std::int64_t>(samples.size()) - 1,
                              begin + Nanoseconds{std::llround(1e9 * (kLength + 0.4))}),
              IsOk());
  ASSERT_THAT((*sound)->finish(), IsOk());
}

// Every photograph becomes one colour, whose red says the frame's number: what the page shows can then be
// read from it.
void number_the_pictures(const fs::path& page) {
  for (int f = 0; f < kFrames; ++f) {
    char name[24] = "";
    std::snprintf(name, sizeof name, "frames/%06d.js", f);
    const Result<std::string> script = read_file(page / name);
    ASSERT_THAT(script, IsOk());
    const std::size_t begin = script->find('{'), end = script->rfind('}') + 1;
    json frame = json::parse(script->substr(begin, end - begin));
    Image color(64, 64, 3, 255);
    for (std::size_t i = 0; i < color.pixels.size(); i += 3)
      color.pixels[i] = static_cast<std::uint8_t>(20 + 5 * f), color.pixels[i + 2] = 0;
    frame["sheet"] = base64(encode_jpeg(color, 100));
    ASSERT_THAT(write_file(page / name, script->substr(0, begin) + frame.dump() + script->substr(end)),
                IsOk());
  }
}

// Looks at the canvas whenever the browser paints: [frame in its pixels, what is heard when it paints next],
// and how long it takes from one to the next.
constexpr const char* kLook = R"((() => {
  const gl = document.getElementById("stage").getContext("webgl2");
  window.seen = [];
  let last = -1;
  const look = () => {
    requestAnimationFrame(look);
    const heard = floatstage.heard;
    if (last >= 0 && heard !== null) window.seen.push([last, heard]);
    if (heard === null) last = -1;
    const width = gl.drawingBufferWidth, row = new Uint8Array(4 * width);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, gl.drawingBufferHeight >> 1, width, 1, gl.RGBA, gl.UNSIGNED_BYTE, row);
    for (let x = 0; x < width; ++x)
      if (row[4 * x + 1] > 240) { last = Math.round((row[4 * x] - 20) / 5); break; }
  };
  look();
  return 0;
})())";

struct Apart {
  std::size_t samples = 0;
  double median = 0, p95 = 0, most = 0;  // ms
};

// How far what is heard is from the time that the picture of the same moment stands for; the take goes round.
Apart apart(const json& seen) {
  std::vector<double> ms;
  for (const json& look : seen) {
    const double begin = look[0].get<double>() / kRate, heard = look[1].get<double>();
    double best = 1e9;
    for (const double round : {-kLength, 0.0, kLength}) {
      const double t = heard + round;
      best = std::min(best, std::max({0.0, begin - t, t - (begin + 1.0 / kRate)}));
    }
    ms.push_back(1e3 * best);
  }
  if (ms.empty()) return {};
  std::sort(ms.begin(), ms.end());
  return {ms.size(), ms[ms.size() / 2], ms[ms.size() * 95 / 100], ms.back()};
}

class APageWithSound : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    const fs::path take =
        processed_take(*folder_, {.cameras = 3, .frames = kFrames, .width = 96, .height = 72});
    add_sound(take);
    ExportWebOptions options;
    options.take = take;
    options.out = *folder_ / "page";
    for (int f = 0; f < kFrames; ++f) options.frames.push_back(f);
    PathKey key;
    key.eye = {3, 0, 1};
    key.target = {0, 0, 1};
    options.path = CameraPath{{key, key}};
    options.path->keys[1].eye = {0, 3, 1};
    options.path->keys[1].time = 1;
    const Result<ExportWebReport> report = export_web(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_NEAR(report->sound, kLength, 1e-6);
    options.out = *folder_ / "silent";
    options.frames = {0, 1};
    options.sound = false;
    ASSERT_THAT(export_web(options), IsOk());
    options.out = *folder_ / "halves";
    options.frames = {0, 2, 4, 6, 8, 10, 12, 14, 16, 18};
    options.sound = true;
    ASSERT_THAT(export_web(options), IsOk());
  }
  static void TearDownTestSuite() { delete folder_; }

  // What was seen and heard in so many seconds from now on.
  static Apart watch(Browser& browser, double seconds) {
    browser.value("(window.seen = [], window.until = performance.now() + " + std::to_string(1e3 * seconds) +
                  ", 0)");
    EXPECT_TRUE(browser.becomes_true("performance.now() > window.until", seconds + 60));
    return apart(browser.value("window.seen"));
  }
  static void expect_together(Browser& browser, const char* when, double seconds) {
    const Apart is = watch(browser, seconds);
    std::printf("%s: %zu pictures, apart by %.1f ms (median), %.1f (19 of 20), %.1f (most)\n", when,
                is.samples, is.median, is.p95, is.most);
    EXPECT_GT(is.samples, 10u) << when;
    EXPECT_LE(is.p95, 40) << when;
  }

  static TempFolder* folder_;
};
TempFolder* APageWithSound::folder_ = nullptr;

TEST_F(APageWithSound, ClicksWhereTheTakeDoes) {
  std::string script = *read_file(*folder_ / "page/sound.js");
  ASSERT_THAT(script, StartsWith("soundLoaded(\""));
  const std::string encoded = script.substr(13, script.find('"', 13) - 13);
  ASSERT_THAT(write_file(*folder_ / "encoded", encoded), IsOk());
  const Ended decoded = run_command(
      text("base64 -d '", (*folder_ / "encoded").string(), "' > '", (*folder_ / "sound.m4a").string(), "'"));
  ASSERT_EQ(decoded.code, 0) << decoded.output;
  const auto sound = capture::MediaSound::open(*folder_ / "sound.m4a");
  ASSERT_THAT(sound, IsOk());
  ASSERT_NE(*sound, nullptr);
  std::vector<double> clicks;
  for (auto block = (*sound)->next(); block; block = (*sound)->next())
    for (std::size_t i = 0; i < block->samples.size(); ++i)
      if (const double t = seconds(block->time) + static_cast<double>(i) / kSoundRate;
          block->samples[i] > 0.4f && (clicks.empty() || t > clicks.back() + 0.1))
        clicks.push_back(t);
  ASSERT_EQ(clicks.size(), std::size_t{kFrames / kClickEach - 1}) << "the first fades in";
  for (std::size_t i = 0; i < clicks.size(); ++i)
    EXPECT_NEAR(clicks[i], static_cast<double>(i + 1) * kClickEach / kRate, 0.005);
}

TEST_F(APageWithSound, IsSeenWhenItIsHeard) {
  number_the_pictures(*folder_ / "page");
  Browser browser(390, 844);
  browser.resize(390, 844);
  browser.open("file://" + (*folder_ / "page/index.html").string());
  ASSERT_TRUE(browser.becomes_true("window.floatstage && floatstage.shown === 0", 60));
  ASSERT_TRUE(browser.becomes_true("!document.getElementById('mute').hidden", 60));
  for (const char* side : {"width", "height"})
    EXPECT_GE(
        browser.value(text("document.getElementById('mute').getBoundingClientRect().", side)).get<double>(),
        44);
  EXPECT_EQ(browser.value("document.documentElement.scrollWidth"), 390);
  EXPECT_EQ(browser.value("floatstage.heard"), nullptr);
  browser.value(kLook);

  browser.click("#play");
  ASSERT_TRUE(browser.becomes_true("floatstage.heard > 0")) << "this browser plays no sound";
  expect_together(browser, "played round and round", 2.2 * kLength);
  if (const char* folder = std::getenv("FLOATSTAGE_PAGE_PICTURES"))
    browser.screenshot(fs::path(folder) / "with-sound.png");
  std::printf("drawn with 1/%d of the pixels, in %.0f ms (%.0f with all)\n",
              1 << browser.value("floatstage.pace.rung").get<int>(),
              browser.value("floatstage.pace.lag").get<double>(),
              browser.value("floatstage.pace.whole").get<double>());
  browser.click("#mute");
  EXPECT_EQ(browser.value("document.getElementById('mute').getAttribute('aria-pressed')"), "true");
  expect_together(browser, "muted", 0.5);
  browser.click("#mute");
  EXPECT_EQ(browser.value("document.getElementById('mute').getAttribute('aria-pressed')"), "false");

  browser.value(
      "(() => { const time = document.getElementById('time'); time.value = 25; "
      "time.dispatchEvent(new Event('input')); return 0; })()");
  EXPECT_EQ(browser.value("floatstage.heard"), nullptr) << "scrubbing is silent";
  browser.click("#play");
  ASSERT_TRUE(browser.becomes_true("floatstage.heard !== null"));
  EXPECT_GE(browser.value("floatstage.heard").get<double>(), 25.0 / kRate - 0.01);
  expect_together(browser, "after scrubbing", 0.8);

  browser.click("#path");
  EXPECT_EQ(browser.value("floatstage.heard"), nullptr) << "a path has a time of its own";
  ASSERT_TRUE(
      browser.becomes_true("document.getElementById('path').getAttribute('aria-pressed') === 'false'"));
  browser.click("#play");
  ASSERT_TRUE(browser.becomes_true("floatstage.heard !== null"));
  expect_together(browser, "after a path", 1);
  browser.click("#play");
  ASSERT_TRUE(browser.becomes_true("document.getElementById('stage').width === 390"))
      << "at rest it is whole again";
}

TEST_F(APageWithSound, AsksForItsSoundAndNothingElsewhere) {
  const FolderServer server(*folder_ / "page");
  Browser browser(390, 844);
  browser.open(server.url() + "index.html");
  ASSERT_TRUE(browser.becomes_true("window.floatstage && !document.getElementById('mute').hidden", 60));
  browser.click("#play");
  ASSERT_TRUE(browser.becomes_true("floatstage.heard > 0"));
  const std::vector<std::string> asked =
      browser.value("performance.getEntriesByType('resource').map(e => e.name)");
  EXPECT_THAT(asked, Contains(EndsWith("sound.js")));
  EXPECT_THAT(asked,
              Each(testing::AnyOf(StartsWith(server.url()), StartsWith("data:"), StartsWith("blob:"))));
}

TEST_F(APageWithSound, OrWithoutShowsNoButtonForIt) {
  EXPECT_FALSE(fs::exists(*folder_ / "silent/sound.js"));
  Browser browser(390, 844);
  browser.open("file://" + (*folder_ / "silent/index.html").string());
  ASSERT_TRUE(browser.becomes_true("window.floatstage && floatstage.shown === 0", 60));
  EXPECT_EQ(browser.value("document.getElementById('mute').hidden"), true);
  browser.click("#play");
  EXPECT_TRUE(browser.becomes_true("floatstage.shown > 0"));
}

TEST_F(APageWithSound, WhoseSoundIsLostPlaysWithoutItAndSaysWhichFileIsMissing) {
  fs::remove(*folder_ / "halves/sound.js");
  Browser browser(390, 844);
  browser.open("file://" + (*folder_ / "halves/index.html").string());
  ASSERT_TRUE(browser.becomes_true("window.floatstage && document.getElementById('mute').disabled", 60));
  EXPECT_THAT(browser.value("document.getElementById('mute').title").get<std::string>(),
              testing::HasSubstr("sound.js is missing; copy the whole folder"));
  browser.click("#play");
  EXPECT_TRUE(browser.becomes_true("floatstage.shown > 0"));
}

TEST_F(APageWithSound, PlaysEverySecondFrameAtTheTakesSpeed) {
  std::string script = *read_file(*folder_ / "halves/take.js");
  script = script.substr(script.find('{'));
  const json page = json::parse(script.substr(0, script.rfind('}') + 1));
  EXPECT_EQ(page["frame_rate"], kRate / 2.0);
  EXPECT_EQ(page["sound"], "sound.js");
}

}  // namespace
}  // namespace floatstage::pipeline
