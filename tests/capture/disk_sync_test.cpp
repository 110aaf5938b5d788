#include "capture/disk_sync.h"

#include <cerrno>
#include <map>
#include <mutex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "capture/recorder.h"
#include "core/synthetic/synthetic_studio.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace {

std::mutex calls_mutex;
std::map<std::string, int> calls;  // of fdatasync(), by file
std::string refused;               // by the disk

}  // namespace

// Stands before the C library's: power cannot be cut here, but what the disk is asked to keep can be seen.
extern "C" int fdatasync(int descriptor) {
  char file[4096] = "";
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  if (::readlink(link.c_str(), file, sizeof file - 1) < 0) return -1;
  {
    const std::lock_guard lock(calls_mutex);
    ++calls[file];
    if (!refused.empty() && std::string(file).ends_with(refused)) {
      errno = EIO;
      return -1;
    }
  }
  return ::fsync(descriptor);
}

namespace floatstage::capture {
namespace {

class DisksAreAsked : public testing::Test {
 protected:
  DisksAreAsked() {
    const std::lock_guard lock(calls_mutex);
    calls.clear();
    refused.clear();
  }
  int asked_for(const std::filesystem::path& file) const {
    const std::lock_guard lock(calls_mutex);
    const auto found = calls.find(std::filesystem::canonical(file).string());
    return found == calls.end() ? 0 : found->second;
  }
  TempFolder folder_;
};

TEST_F(DisksAreAsked, ToKeepEveryFileAndFolderOfATakeWhileItGrowsAndWhenItEnds) {
  const Rig rig = synthetic_rig({});
  RecorderOptions options;
  options.sync_seconds = 0.02;
  options.take.codec = TakeCodec::Raw;
  const std::filesystem::path take = folder_ / "take";
  Result<std::unique_ptr<Recorder>> recorder = Recorder::start(take, rig, options);
  ASSERT_THAT(recorder, IsOk());
  EXPECT_TRUE(eventually([&] { return asked_for(take / "take.json") >= 3; })) << "again and again";
  ASSERT_THAT((*recorder)->finish(), IsOk());
  for (const auto& entry : std::filesystem::recursive_directory_iterator(take))
    EXPECT_GE(asked_for(entry.path()), 1) << entry.path();
  EXPECT_GE(asked_for(take / "quality.json"), 1) << "written last";
}

TEST_F(DisksAreAsked, NothingWhereItIsNotWanted) {
  Result<std::unique_ptr<Recorder>> recorder = Recorder::start(folder_ / "take", synthetic_rig({}), {});
  ASSERT_THAT(recorder, IsOk());
  ASSERT_THAT((*recorder)->finish(), IsOk());
  EXPECT_EQ(asked_for(folder_ / "take" / "take.json"), 0);
}

TEST_F(DisksAreAsked, AndWhatTheyRefuseIsNamed) {
  folder_.write("a", "x");
  std::filesystem::create_symlink("/etc/passwd", folder_ / "link");
  EXPECT_THAT(sync_folder(folder_.path()), IsOk());
  EXPECT_EQ(asked_for("/etc/passwd"), 0) << "no link is followed";
  refused = "/a";
  EXPECT_THAT(sync_folder(folder_.path()), FailsWith(ErrorCode::Io, "a: Input/output error"));
}

}  // namespace
}  // namespace floatstage::capture
