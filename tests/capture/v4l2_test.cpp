// Boots Debian's kernel with the test camera vivid under qemu, runs guest_test.cpp inside, and looks on this
// side at what it recorded; and again with systemd, which runs the camera node's unit, and a GigE camera.

#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "capture/take.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/capture/v4l2_guest/pixels_hash.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::HasSubstr;

TEST(VividUnderQemu, StreamsRecordsAndSurvivesEveryFault) {
  const TempFolder folder;
  const std::string out = (folder / "out").string();
  std::filesystem::create_directories(out);
  const std::string command = text(FLOATSTAGE_GUEST_SCRIPT, " ", FLOATSTAGE_GUEST_KERNEL, " ", out,
                                   " env FLOATSTAGE_GUEST_OUT=", out, " ", FLOATSTAGE_GUEST_TEST, " 2>&1");
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0) << "a test inside the guest failed; its output is above";

  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(out + "/take");
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->warnings().empty());
  std::ifstream hashes(out + "/hashes.txt");
  int pictures = 0;
  std::uint64_t sequence = 0, hash = 0;
  std::int64_t ns = 0;
  while (hashes >> sequence >> ns >> hash) {
    const Result<Frame> frame = (*take)->frame(0, static_cast<int>(sequence));
    ASSERT_THAT(frame, IsOk());
    ASSERT_FALSE(frame->empty()) << "picture " << sequence;
    EXPECT_EQ(frame->info.exposure_start.ns, ns);
    EXPECT_EQ(pixels_hash(*frame), hash) << "picture " << sequence;
    ++pictures;
  }
  EXPECT_EQ(pictures, 300);
}

std::string said_in(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  return bytes ? *bytes : bytes.error().message;
}

/// A whole take, as it was sealed.
void expect_recorded(const std::string& folder, int more_than) {
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(folder);
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete);
  EXPECT_GT((*take)->frame_count(), more_than);
  const Result<Frame> frame = (*take)->frame(0, 0);
  ASSERT_THAT(frame, IsOk());
  EXPECT_FALSE(frame->empty());
  EXPECT_EQ(std::system(text(FLOATSTAGE_PROGRAM, " take verify ", folder).c_str()), 0);
}

TEST(CamerasUnderQemu, AreRecordedByTheUnitAsItIsInstalled) {
  if (kSanitized) GTEST_SKIP() << "a sanitized program needs more memory than the guest has";
  const TempFolder folder;
  const std::string out = (folder / "out").string();
  std::filesystem::create_directories(out);
  folder.write("out/studio.toml", R"([studio]
name = "vivid"
frame_rate = 15
[recording]
folder = "/var/lib/floatstage/takes"
codec = "raw"
[[camera]]
serial = "vivid"
source = "v4l2:/dev/video0?format=gray8&width=320&height=180&rate=15&buffers=16"
)");
  // By its serial number alone: it answers to a broadcast.
  folder.write("out/gige.toml", R"([studio]
name = "gige"
frame_rate = 10
[recording]
folder = "/var/lib/floatstage/takes"
codec = "raw"
[[camera]]
serial = "FAKE1"
source = "gige:FAKE1?format=gray8&width=320&height=240&rate=10&resend=off&buffers=16"
)");
  const std::string command =
      text("GUEST_COMMAND_IS_INIT=1 ", FLOATSTAGE_GUEST_SCRIPT, " ", FLOATSTAGE_GUEST_KERNEL, " ", out, " ",
           FLOATSTAGE_GUEST_UNIT_SCRIPT, " ", FLOATSTAGE_UNIT, " ", FLOATSTAGE_PROGRAM, " ", out, " 2>&1");
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 0) << said_in(out + "/watch.log");
  // The restrictions were in force for the recorder, and another program in its place got no further, which
  // without the unit gets everything.
  EXPECT_THAT(
      said_in(out + "/floatstage-capture.log"),
      testing::AllOf(HasSubstr(FLOATSTAGE_PROGRAM), HasSubstr("NoNewPrivs:\t1"), HasSubstr("Seccomp:\t2"),
                     HasSubstr("CapEff:\t0000000000002000"),  // CAP_NET_RAW
                     HasSubstr("out/take: ")));
  EXPECT_EQ(said_in(out + "/probe.txt"),
            "a camera: yes\nanother device: no\na private network: yes\na public network: no\na mount: no\na "
            "namespace: no\na file of the system: no\n"
            "another personality: no\n");
  EXPECT_EQ(said_in(out + "/outside.txt"),
            "a camera: yes\nanother device: yes\na private network: yes\na public network: yes\na mount: "
            "yes\na namespace: yes\na file of the system: yes\n"
            "another personality: yes\n");
  // Vivid and the GigE camera, which needs the network that the unit allows; it has a second way where it may
  // not receive below the IP stack.
  const std::string ended = said_in(out + "/ended.txt");
  EXPECT_THAT(ended, testing::StartsWith("floatstage-capture: 0\ngige: 0\ngige-without-packets: 0\n"))
      << said_in(out + "/gige.log");
  EXPECT_THAT(ended, testing::ContainsRegex("gige-without-internet: [1-9]"));
  EXPECT_THAT(ended, testing::ContainsRegex("gige-without-addresses: [1-9]"));
  EXPECT_THAT(said_in(out + "/gige.log"), HasSubstr("packet sockets: 1"));
  EXPECT_THAT(said_in(out + "/gige-without-packets.log"), HasSubstr("packet sockets: 0"));
  EXPECT_FALSE(std::filesystem::exists(out + "/none"));
  expect_recorded(out + "/take", 30);  // of 90: an emulated processor misses some
  expect_recorded(out + "/gige", 5);   // of 20
}

}  // namespace
}  // namespace floatstage::capture
