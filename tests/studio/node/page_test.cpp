// The node's page in a headless Chromium.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "capture/take.h"
#include "studio/node/capture_node.h"
#include "studio/page/page_server.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/capture/gige_features.h"
#include "tests/studio/node/studios.h"
#include "tests/support/browser.h"
#include "tests/support/matchers.h"
#include "tests/support/own_network.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

/// A node with its page, looked after by a thread.
class ANodesPage : public testing::Test {
 protected:
  virtual CaptureConfig config() {  // eight live cameras with pictures that one can look at
    CaptureConfig config = live_studio(8, 10, folder_.path());
    for (CaptureConfig::Camera& camera : config.cameras) {
      camera.source.replace(camera.source.find("loop=2&width=64&height=48"), 25,
                            "loop=2&width=320&height=240");
    }
    config.preroll_seconds = 1;
    return config;
  }
  void SetUp() override {
    auto node = CaptureNode::open(config());
    ASSERT_THAT(node, IsOk());
    node_ = std::move(*node);
    auto page = PageServer::serve(*node_, node_->config().cameras.size(), {0, "127.0.0.1", {}, {}},
                                  "a-token-of-this-test");
    ASSERT_THAT(page, IsOk());
    page_ = std::move(*page);
    node_->add_tap([this](const Frame& frame) { page_->offer(frame); });
    node_->begin();
    keeper_ = std::thread([this] {
      for (; !done_; std::this_thread::sleep_for(std::chrono::milliseconds(50))) node_->poll();
    });
  }
  void TearDown() override {
    done_ = true;
    if (keeper_.joinable()) keeper_.join();
    if (node_) (void)node_->finish();  // no camera may offer pictures to a page that has gone
    page_.reset();
    node_.reset();
  }
  // Where a person asks to look at what the page looks like.
  void keep(Browser& browser, const std::string& name) {
    if (const char* folder = std::getenv("FLOATSTAGE_PAGE_PICTURES"))
      browser.screenshot(std::filesystem::path(folder) / (name + ".png"));
  }

  TempFolder folder_;
  std::unique_ptr<CaptureNode> node_;
  std::unique_ptr<PageServer> page_;
  std::atomic<bool> done_{false};
  std::thread keeper_;
};

constexpr const char* kTiles = "document.querySelectorAll('#tiles .tile').length";
constexpr const char* kPictures =
    "[...document.querySelectorAll('#tiles canvas')].filter(c => c.width > 100 && "
    "c.getContext('2d').getImageData(c.width / 2, c.height / 2, 1, 1).data[3] === 255).length === 8";

TEST_F(ANodesPage, ShowsTheCamerasAndRecordsTakes) {
  Browser browser(1280, 900);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 8"));
  EXPECT_EQ(browser.value("location.search"), "") << "the token is not left in the address";
  EXPECT_TRUE(browser.becomes_true(kPictures)) << "all previews come over the one connection";
  EXPECT_EQ(browser.value("document.querySelector('#tiles .serial').textContent"), "CAM1");
  EXPECT_TRUE(browser.becomes_true("document.getElementById('cameras-up').textContent === '8 of 8'"));
  EXPECT_TRUE(browser.becomes_true("document.querySelectorAll('#takes li').length === 0"));
  keep(browser, "live");

  browser.type("#label", "first-try");
  browser.click("#record");
  EXPECT_TRUE(browser.becomes_true("document.getElementById('state').dataset.state === 'recording'"));
  EXPECT_TRUE(browser.becomes_true("document.getElementById('record').textContent.trim() === 'Stop'"));
  EXPECT_TRUE(browser.becomes_true("document.querySelectorAll('#takes li').length === 1"));
  EXPECT_TRUE(browser.becomes_true("!document.getElementById('record').disabled"));
  keep(browser, "recording");
  browser.click("#record");
  EXPECT_TRUE(
      browser.becomes_true("/PASS|FAIL/.test(document.querySelector('#takes .verdict').textContent)"));
  EXPECT_TRUE(browser.becomes_true("document.getElementById('state').dataset.state === 'live'"));
  keep(browser, "recorded");

  const Result<std::vector<NodeTake>> takes = node_->takes();
  ASSERT_THAT(takes, IsOk());
  ASSERT_EQ(takes->size(), 1u);
  EXPECT_EQ(browser.value("document.querySelector('#takes .name').textContent"), takes->front().name);
  EXPECT_NE(takes->front().name.find("-first-try"), std::string::npos);
  const auto take = capture::TakeReader::open(folder_ / takes->front().name);
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete);
  EXPECT_EQ((*take)->rig().cameras.size(), 8u);
}

class ANodesPageWithSound : public ANodesPage {
 protected:
  CaptureConfig config() override {
    CaptureConfig config = ANodesPage::config();
    config.cameras.resize(2);
    config.sounds = {"tone:1000"};
    return config;
  }
};

TEST_F(ANodesPageWithSound, ShowsHowLoudItIsWhileItIsRecorded) {
  Browser browser(1280, 900);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 2"));
  EXPECT_TRUE(browser.becomes_true("document.getElementById('sound-figure').hidden"));
  browser.click("#record");
  // The tone is a quarter of full scale.
  EXPECT_TRUE(browser.becomes_true("/^-12 dB/.test(document.getElementById('sound').textContent)"));
  EXPECT_TRUE(browser.becomes_true("!document.getElementById('sound-figure').hidden"));
  keep(browser, "sound");
  browser.click("#record");
  EXPECT_TRUE(browser.becomes_true("document.getElementById('sound-figure').hidden"));
}

TEST_F(ANodesPage, FitsATelephoneAndCanBeUsedWithoutAMouse) {
  Browser browser(390, 844);
  browser.resize(390, 844);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 8"));
  EXPECT_TRUE(browser.becomes_true(kPictures));
  EXPECT_EQ(browser.value("document.documentElement.scrollWidth"), browser.value("window.innerWidth"));
  keep(browser, "telephone");
  // Everything that can be pressed has a name, every picture words, and the letters stand out.
  EXPECT_EQ(
      browser.value("[...document.querySelectorAll('button,input')].filter(e => !(e.textContent.trim() || "
                    "e.labels && e.labels.length)).length"),
      0);
  EXPECT_EQ(browser.value(
                "[...document.querySelectorAll('canvas')].filter(e => !e.getAttribute('aria-label')).length"),
            0);
  EXPECT_EQ(browser.value("document.documentElement.lang"), "en");
  ASSERT_TRUE(browser.becomes_true("!document.getElementById('record').disabled"));
  browser.type("body", "r");
  EXPECT_TRUE(
      browser.becomes_true("document.getElementById('record').getAttribute('aria-pressed') === 'true'"));
}

TEST_F(ANodesPage, SaysSoWhenTheNodeIsGone) {
  Browser browser(1280, 900);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 8"));
  done_ = true;
  keeper_.join();
  ASSERT_THAT(node_->finish(), IsOk());
  page_.reset();
  EXPECT_TRUE(browser.becomes_true("document.getElementById('state').dataset.state === 'away'"));
  EXPECT_EQ(browser.value("document.getElementById('record').disabled"), true);
}

/// Of one GigE camera, whose knobs can be turned, and a larger one without.
class APageWithKnobs : public ANodesPage {
 protected:
  void SetUp() override {
    ASSERT_TRUE(enter_own_network());
    camera_ = std::make_unique<capture::FakeGigeCamera>(
        1, "GIGE", 0, capture::described_with(capture::white_balance_features(), folder_));
    ANodesPage::SetUp();
  }
  CaptureConfig config() override {
    CaptureConfig config = live_studio(1, 10, folder_.path());
    config.cameras[0].source =
        "synthetic:live=on&loop=2&width=960&height=720&samples=1&cameras=4&camera=1&rate=10";
    config.cameras.push_back(
        {"GIGE", camera_->uri("format=gray8&width=512&height=384&rate=10&exposure-us=9000")});
    config.presets = folder_ / "studio.presets.toml";
    return config;
  }
  static std::string knob(const char* name) { return text("#knobs input[name=\"", name, "\"]"); }
  static std::string value_of(const char* name) {
    return text("Number((document.querySelector('", knob(name), "') || {}).value)");
  }
  // As a person turns it: the number is typed over, and Enter is pressed.
  static void turn(Browser& browser, const char* name, const std::string& to) {
    (void)browser.value(
        text("(e => { e.focus(); e.value = ''; return 0; })(document.querySelector('", knob(name), "'))"));
    browser.type(knob(name), to + "\n");
  }
  double exposure() {
    const std::vector<NodeControls> all = node_->controls();
    for (const capture::CameraControl& control : all[1].controls)
      if (control.name == "exposure-us") return control.value;
    return -1;
  }

  std::unique_ptr<capture::FakeGigeCamera> camera_;
};

constexpr const char* kAdjustGige = "#tiles li:nth-child(2) .adjust";
// What the preview shows changes with the light: the mean of its pixels.
constexpr const char* kBrightness =
    "(c => { const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let sum = 0; "
    "for (let i = 0; i < p.length; i += 4) sum += p[i]; return 4 * sum / p.length; })"
    "(document.querySelector('#tiles li:nth-child(2) canvas'))";

TEST_F(APageWithKnobs, SetsTheLightAndKeepsPresets) {
  Browser browser(1280, 900);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 2"));
  browser.click(kAdjustGige);
  ASSERT_TRUE(browser.becomes_true("document.querySelectorAll('#knobs label').length === 5"));
  EXPECT_EQ(browser.value("document.getElementById('focus-title').textContent"), "Camera GIGE");
  EXPECT_TRUE(browser.becomes_true(value_of("exposure-us") + " === 9000"));
  ASSERT_TRUE(browser.becomes_true(text(kBrightness, " > 10")));
  const double before = browser.value(kBrightness).get<double>();
  keep(browser, "knobs");

  turn(browser, "exposure-us", "1000");
  EXPECT_TRUE(browser.becomes_true(text(kBrightness, " < ", before / 2))) << "the pictures are darker";
  EXPECT_EQ(exposure(), 1000);
  browser.type("#preset", "dark");
  browser.click("#presets button[value=save]");
  EXPECT_TRUE(
      browser.becomes_true("(document.querySelector('#preset-names option') || {}).value === 'dark'"));

  turn(browser, "exposure-us", "1e12");
  EXPECT_TRUE(
      browser.becomes_true("/GIGE.: exposure-us = 1000000000000 is out of "
                           "range/.test(document.getElementById('knob-error').textContent)"));
  EXPECT_TRUE(browser.becomes_true(value_of("exposure-us") + " === 1000")) << "it stays as it was";
  keep(browser, "refused");
  turn(browser, "exposure-us", "20000");
  EXPECT_TRUE(browser.becomes_true(text(kBrightness, " > ", before)));
  EXPECT_TRUE(browser.becomes_true("document.getElementById('knob-error').textContent === ''"));
  browser.click("#presets button[value=apply]");
  EXPECT_TRUE(browser.becomes_true(value_of("exposure-us") + " === 1000"));
  EXPECT_EQ(exposure(), 1000);
}

constexpr const char* kZoomed =
    "(c => c.getContext('2d').getImageData(0, 0, c.width, c.height).data)(document.getElementById('zoom'))";

std::string count_of(const char* condition) {
  return text("((p) => { let n = 0; for (let i = 0; i < p.length; i += 4) if (", condition,
              ") ++n; return n; })(", kZoomed, ")");
}

TEST_F(APageWithKnobs, HelpsToFocusAndShowsWhatIsClipped) {
  Browser browser(390, 844);
  browser.resize(390, 844);
  browser.open(page_->url());
  ASSERT_TRUE(browser.becomes_true(std::string(kTiles) + " === 2"));
  ASSERT_TRUE(browser.becomes_true("document.querySelector('#tiles canvas').width > 100"));
  browser.click("#tiles li:nth-child(1) canvas");  // its middle, where the subject is
  ASSERT_TRUE(browser.becomes_true("/Sharpness \\d/.test(document.getElementById('sharpness').textContent)"));
  EXPECT_EQ(browser.value("document.getElementById('zoom').width"), 320);
  EXPECT_EQ(browser.value("document.getElementById('knobs').textContent"),
            "This camera has nothing to set while it streams.");
  const std::string peaks = count_of("p[i] === 60 && p[i + 1] === 255 && p[i + 2] === 90");
  EXPECT_TRUE(browser.becomes_true(peaks + " > 20")) << "edges are marked";
  EXPECT_EQ(browser.value("document.documentElement.scrollWidth"), browser.value("window.innerWidth"));
  keep(browser, "focus-telephone");
  browser.click("#peaking");
  EXPECT_TRUE(browser.becomes_true(peaks + " === 0"));

  // The fake camera's ramp, four times over at this gain, is white in its second half.
  ASSERT_THAT(node_->set_control("GIGE", "gain", 3), IsOk());
  browser.click(kAdjustGige);
  EXPECT_TRUE(
      browser.becomes_true(count_of("p[i] === 255 && p[i + 1] === 40 && p[i + 2] === 40") + " > 1000"))
      << "what is white is red";
  keep(browser, "clipped-telephone");
  browser.click("#focus-close");
  EXPECT_TRUE(browser.becomes_true("document.getElementById('focus').hidden"));
}

}  // namespace
}  // namespace floatstage::studio
