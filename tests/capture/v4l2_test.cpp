// Boots Debian's kernel with the test camera vivid under qemu, runs guest_test.cpp inside, and looks on this
// side at what it recorded.

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "capture/take.h"
#include "core/text.h"
#include "tests/capture/v4l2_guest/pixels_hash.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

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

}  // namespace
}  // namespace floatstage::capture
