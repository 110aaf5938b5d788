// The node's page in a headless Chromium.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "capture/take.h"
#include "studio/node/capture_node.h"
#include "studio/page/page_server.h"
#include "tests/studio/node/studios.h"
#include "tests/support/browser.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

/// A node of eight live cameras with its page, looked after by a thread.
class ANodesPage : public testing::Test {
 protected:
  void SetUp() override {
    CaptureConfig config = live_studio(8, 10, folder_.path());
    for (CaptureConfig::Camera& camera : config.cameras) {  // pictures that one can look at
      camera.source.replace(camera.source.find("loop=2&width=64&height=48"), 25,
                            "loop=2&width=320&height=240");
    }
    config.preroll_seconds = 1;
    auto node = CaptureNode::open(config);
    ASSERT_THAT(node, IsOk());
    node_ = std::move(*node);
    auto page = PageServer::serve(*node_, 8, {0, "127.0.0.1", {}, {}}, "a-token-of-this-test");
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

}  // namespace
}  // namespace floatstage::studio
