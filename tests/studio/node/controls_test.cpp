// What an operator turns on a node's cameras, and keeps.
#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "studio/node/camera_presets.h"
#include "studio/node/capture_node.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/studio/node/studios.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"
#include "tests/support/own_network.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A node of a GigE camera, GIGE, and one without knobs, CAM1.
class ANodesControls : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(enter_own_network());
    camera_ = std::make_unique<capture::FakeGigeCamera>(1, "GIGE");
    config_ = live_studio(1, 20, folder_.path());
    config_.cameras.push_back(
        {"GIGE", camera_->uri("format=gray8&width=64&height=48&rate=20&exposure-us=5000")});
    config_.presets = folder_ / "studio.presets.toml";
  }
  void begin() {
    auto node = CaptureNode::open(config_);
    ASSERT_THAT(node, IsOk());
    node_ = std::move(*node);
    node_->begin();
  }
  void TearDown() override {
    if (node_) (void)node_->finish();
  }
  double value_of(const std::string& name) {
    const std::vector<NodeControls> all = node_->controls();
    EXPECT_EQ(all[0].serial, "CAM1");
    EXPECT_THAT(all[0].controls, IsEmpty());
    for (const capture::CameraControl& control : all[1].controls)
      if (control.name == name) return control.value;
    return -1;
  }

  TempFolder folder_;
  std::unique_ptr<capture::FakeGigeCamera> camera_;
  CaptureConfig config_;
  std::unique_ptr<CaptureNode> node_;
};

TEST_F(ANodesControls, AreTurnedWhileItStreams) {
  ASSERT_NO_FATAL_FAILURE(begin());
  EXPECT_EQ(value_of("exposure-us"), 5000);
  ASSERT_THAT(node_->set_control("GIGE", "exposure-us", 2000), IsOk());
  EXPECT_EQ(value_of("exposure-us"), 2000);
  EXPECT_THAT(node_->set_control("GIGE", "exposure-us", -1),
              FailsWith(ErrorCode::InvalidArgument,
                        "camera 'GIGE': exposure-us = -1 is out of range; it takes 10 to"));
  EXPECT_THAT(node_->set_control("CAM1", "gain", 1), FailsWith(ErrorCode::NotFound, "'gain'"));
  EXPECT_THAT(node_->set_control("NONE", "gain", 1), FailsWith(ErrorCode::NotFound, "no camera 'NONE'"));
  EXPECT_EQ(value_of("exposure-us"), 2000);
}

TEST_F(ANodesControls, AreSetAgainWhenTheCameraIsBack) {
  ASSERT_NO_FATAL_FAILURE(begin());
  ASSERT_THAT(node_->set_control("GIGE", "exposure-us", 2000), IsOk());
  camera_->kill();
  camera_ = std::make_unique<capture::FakeGigeCamera>(1, "GIGE");  // it wakes with its own
  ASSERT_TRUE(eventually([&] { return node_->status().cameras[1].reconnects == 1; }));
  EXPECT_TRUE(eventually([&] { return value_of("exposure-us") == 2000; })) << value_of("exposure-us");
}

TEST_F(ANodesControls, AreKeptUnderANameAndSetAgain) {
  ASSERT_NO_FATAL_FAILURE(begin());
  EXPECT_THAT(*node_->presets(), IsEmpty());
  ASSERT_THAT(node_->save_preset("evening"), IsOk());
  ASSERT_THAT(node_->set_control("GIGE", "exposure-us", 2000), IsOk());
  ASSERT_THAT(node_->set_control("GIGE", "gain", 3), IsOk());
  ASSERT_THAT(node_->save_preset("day"), IsOk());
  EXPECT_THAT(*node_->presets(), ElementsAre("day", "evening"));
  ASSERT_THAT(node_->apply_preset("evening"), IsOk());
  EXPECT_EQ(value_of("exposure-us"), 5000);
  ASSERT_THAT(node_->finish(), IsOk());
  ASSERT_NO_FATAL_FAILURE(begin());  // another day
  ASSERT_THAT(node_->apply_preset("day"), IsOk());
  EXPECT_EQ(value_of("exposure-us"), 2000);
  EXPECT_EQ(value_of("gain"), 3);
  EXPECT_THAT(node_->apply_preset("night"), FailsWith(ErrorCode::NotFound, "no preset 'night'"));
  for (const char* name : {"", "../up", "two words"})
    EXPECT_THAT(node_->save_preset(name), FailsWith(ErrorCode::InvalidArgument, "letters, digits")) << name;
}

TEST_F(ANodesControls, OfAPresetAreSetAsFarAsTheyCanBe) {
  folder_.write("studio.presets.toml",
                "[odd.GIGE]\nexposure-us = 1e12\ngain = 2\nglow = 1\n[odd.AWAY]\ngain = 3\n");
  ASSERT_NO_FATAL_FAILURE(begin());
  EXPECT_THAT(node_->apply_preset("odd"), FailsWith(ErrorCode::NotFound, "no camera 'AWAY'"));
  EXPECT_EQ(value_of("gain"), 2);
  EXPECT_EQ(value_of("exposure-us"), 5000);
}

TEST_F(ANodesControls, SayWhichPresetsFileIsWrongAndLeaveItAlone) {
  const std::string torn = "[day.GIGE]\ngain = \"much\"\n";
  folder_.write("studio.presets.toml", torn);
  ASSERT_NO_FATAL_FAILURE(begin());
  EXPECT_THAT(node_->save_preset("evening"),
              FailsWith(ErrorCode::BadData, "studio.presets.toml, line 2: a control is a number"));
  EXPECT_THAT(node_->presets(), FailsWith(ErrorCode::BadData, "line 2"));
  EXPECT_EQ(*read_file(config_.presets), torn);
}

TEST_F(ANodesControls, OfACameraThatHangsKeepNobodyForLong) {
  ASSERT_NO_FATAL_FAILURE(begin());
  camera_->freeze();
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_THAT(node_->set_control("GIGE", "gain", 1), testing::Not(IsOk()));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(6));
  camera_->thaw();
}

TEST(CameraPresets, AreReadAsTheyWereWritten) {
  const TempFolder folder;
  const CameraPresets presets = {
      {"day", {{"A1", {{"exposure-us", 8333.25}, {"gain", -3}}}, {"a.b", {{"gain", 1e9}}}}},
      {"v1.0", {{"A1", {{"white-balance-red", 1.0 / 3}}}}}};
  ASSERT_THAT(save_presets(presets, folder / "p.toml"), IsOk());
  const Result<CameraPresets> read = load_presets(folder / "p.toml");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(*read, presets);
  EXPECT_THAT(*load_presets(folder / "none.toml"), IsEmpty());
}

TEST(CameraPresets, OfAForeignFileAreRefusedWithItsLine) {
  const TempFolder folder;
  for (const char* bytes :
       {"day = 3", "[day]\nA1 = 3", "[day.A1]\ngain = nan", "[day.A1]\ngain = inf", "[day.A1]\ngain = [1]",
        "[day.A1]\ngain = true", "[day", "\xff\xfe", "[\"two words\".A1]\ngain = 1"})
    EXPECT_THAT(load_presets(folder.write("p.toml", bytes)), FailsWith(ErrorCode::BadData, "p.toml, line "))
        << bytes;
  EXPECT_THAT(load_presets(folder.write("p.toml", "day.A1.gain = 1\n" + std::string(200'000, '['))),
              FailsWith(ErrorCode::BadData, "p.toml, line "));
}

}  // namespace
}  // namespace floatstage::studio
