#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/check/studio.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using Verdict = Finding::Verdict;

auto says(Verdict verdict, const std::string& words) {
  return Contains(AllOf(Field(&Finding::verdict, verdict), Field(&Finding::what, HasSubstr(words))));
}

std::vector<Finding> found_in(const TempFolder& folder, const std::string& more,
                              const std::string& studio = "") {
  const auto config = folder.write("studio.toml", text(R"([studio]
frame_rate = 25
)",
                                                       studio, R"([recording]
folder = "to/come"
[[camera]]
serial = "A"
source = "synthetic:cameras=2&camera=0&width=64&height=48&samples=1&rate=25"
)",
                                                       more));
  const Result<std::vector<Finding>> findings = look_at_studio(config);
  EXPECT_THAT(findings, IsOk());
  return findings ? *findings : std::vector<Finding>{};
}

TEST(CheckStudio, StartsEachCameraAndSaysWhatItDelivers) {
  const TempFolder folder;
  const std::vector<Finding> found = found_in(folder, "");
  EXPECT_THAT(found, says(Verdict::Pass, "camera A: 64x48 rgb8 at 25 a second"));
  EXPECT_THAT(found, says(Verdict::Pass, "the config's cameras need 0.2 MB a second"));
  EXPECT_FALSE(std::filesystem::exists(folder / "to")) << "it only looks";
}

TEST(CheckStudio, OpensItsSourcesOfSoundToo) {
  const TempFolder folder;
  const std::vector<Finding> found =
      found_in(folder, "[[sound]]\nsource = \"tone:440\"\n[[sound]]\nsource = \"alsa:hw:77\"\n");
  EXPECT_THAT(found, says(Verdict::Pass, "sound tone:440: 1 channels of 48000 samples a second"));
  EXPECT_THAT(found, says(Verdict::Fail, "sound: cannot record from alsa:hw:77"));
}

TEST(CheckStudio, SaysWhyACameraDoesNotStartAndGoesOn) {
  const TempFolder folder;
  const std::vector<Finding> found = found_in(folder, R"([[camera]]
serial = "B"
source = "v4l2:/dev/video77"
[[camera]]
serial = "C"
source = "synthetic:cameras=2&camera=1&width=64&height=48&samples=1&rate=20"
[[camera]]
serial = "D"
source = "radio:4"
)");
  EXPECT_THAT(found, says(Verdict::Fail, "camera B: camera '/dev/video77': it is not there"));
  EXPECT_THAT(found, says(Verdict::Warn, "at 20 a second where the config says 25"));
  EXPECT_THAT(found, says(Verdict::Fail, "camera D: "));
  EXPECT_THAT(found, says(Verdict::Pass, "camera A: "));
}

TEST(CheckStudio, TriesThePagesPort) {
  const TempFolder folder;
  EXPECT_THAT(found_in(folder, "[web]\nport = 0\n"), says(Verdict::Pass, "for the node's page is free"));
  EXPECT_THAT(found_in(folder, "[web]\naddress = \"203.0.113.7\"\n"),
              says(Verdict::Fail, "cannot be served"));
}

TEST(CheckStudio, TriesThePortsOfItsNetwork) {
  const TempFolder folder;
  const std::vector<Finding> found = found_in(folder, R"([publish]
address = "tcp://203.0.113.7:5570"
control = "somewhere"
)",
                                              "rig = \"rig.json\"\n");
  EXPECT_THAT(found, says(Verdict::Fail, "rig.json"));
  EXPECT_THAT(found, says(Verdict::Fail, "203.0.113.7:5570 for the node's outlines cannot be served"));
  EXPECT_THAT(found, says(Verdict::Fail, "'somewhere' for requests to the node is not tcp://"));
  EXPECT_THAT(found_in(folder, "[publish]\naddress = \"tcp://127.0.0.1:0\"\n", "rig = \"rig.json\"\n"),
              says(Verdict::Pass, "for the node's outlines is free"));
}

TEST(CheckStudio, RefusesAConfigThatIsNone) {
  const TempFolder folder;
  EXPECT_THAT(look_at_studio(folder / "none.toml"), FailsWith(ErrorCode::NotFound, "none.toml"));
  EXPECT_THAT(look_at_studio(folder.write("bad.toml", "[studio]\nframe_rate = 25\n")),
              FailsWith(ErrorCode::BadData, "names no [[camera]]"));
}

}  // namespace
}  // namespace floatstage::apps
