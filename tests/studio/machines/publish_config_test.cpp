#include <gtest/gtest.h>

#include "studio/node/capture_config.h"
#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

Result<CaptureConfig> parsed(const std::string& publish, const std::string& rig = "rig = 'rig.json'") {
  return parse_capture_config("[studio]\nframe_rate = 25\n" + rig + "\n" + publish +
                                  "\n[[camera]]\nserial = 'a'\nsource = 'v4l2:/dev/video0'\n",
                              "studio.toml", "/studio");
}

TEST(PublishConfig, IsNotThereUnlessAskedFor) { EXPECT_FALSE(parsed("")->publish); }

TEST(PublishConfig, StaysOnThisMachineByDefault) {
  const Result<CaptureConfig> config = parsed("[publish]");
  ASSERT_THAT(config, IsOk());
  ASSERT_TRUE(config->publish);
  EXPECT_EQ(config->publish->address, "tcp://127.0.0.1:5570");
  EXPECT_EQ(config->publish->control, "tcp://127.0.0.1:5571");
  EXPECT_TRUE(config->publish->keys.empty());
  EXPECT_FALSE(config->publish->raw_tiles);
}

TEST(PublishConfig, SaysWhereAndHow) {
  const Result<CaptureConfig> config = parsed(
      "[publish]\naddress = 'tcp://*:1'\ncontrol = 'tcp://*:2'\nkeys = 'studio.keys'\nkey = 'difference'\n"
      "plates = 'plates'\nshrink = 4\ntiles = 'raw'\njpeg_quality = 95\n");
  ASSERT_THAT(config, IsOk());
  const CaptureConfig::Publish& publish = *config->publish;
  EXPECT_EQ(publish.address, "tcp://*:1");
  EXPECT_EQ(publish.control, "tcp://*:2");
  EXPECT_EQ(publish.keys, "/studio/studio.keys");
  EXPECT_EQ(publish.key, "difference");
  EXPECT_EQ(publish.plates, "/studio/plates");
  EXPECT_EQ(publish.shrink, 4);
  EXPECT_TRUE(publish.raw_tiles);
  EXPECT_EQ(publish.jpeg_quality, 95);
}

TEST(PublishConfig, NamesWhatItDoesNotUnderstand) {
  EXPECT_THAT(parsed("[publish]\nport = 5570"), FailsWith(ErrorCode::BadData, "'port' is not understood"));
  EXPECT_THAT(parsed("[publish]\ntiles = 'png'"), FailsWith(ErrorCode::BadData, "tiles must be jpeg or raw"));
  EXPECT_THAT(parsed("[publish]\njpeg_quality = 0"), FailsWith(ErrorCode::BadData, "jpeg_quality must be"));
}

TEST(PublishConfig, NeedsACalibration) {
  EXPECT_THAT(parsed("[publish]", ""), FailsWith(ErrorCode::BadData, "name the rig in [studio]"));
}

}  // namespace
}  // namespace floatstage::studio
