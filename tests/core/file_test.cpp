#include "core/file.h"

#include <csignal>
#include <cstdlib>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

using testing::ElementsAre;
using testing::Eq;

TEST(File, ComesBackWithEveryByte) {
  const TempFolder folder;
  std::string bytes(200'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
  ASSERT_THAT(write_file(folder / "a.bin", bytes), IsOk());
  EXPECT_THAT(read_file(folder / "a.bin"), IsOkAnd(Eq(bytes)));
  EXPECT_THAT(folder.names(), ElementsAre("a.bin")) << "the temporary name stayed behind";
}

TEST(File, ReplacesAnOlderOneWhole) {
  const TempFolder folder;
  folder.write("a.txt", "a long old text");
  ASSERT_THAT(write_file(folder / "a.txt", "new"), IsOk());
  EXPECT_THAT(read_file(folder / "a.txt"), IsOkAnd(Eq("new")));
}

TEST(File, ThatIsNotThereIsNotFound) {
  EXPECT_THAT(read_file("/nowhere/a"), FailsWith(ErrorCode::NotFound, "/nowhere/a"));
}

TEST(File, ThatIsAFolderIsAnIoError) {
  const TempFolder folder;
  EXPECT_THAT(read_file(folder.path()), FailsWith(ErrorCode::Io, folder.path().string()));
}

TEST(File, InAFolderThatIsNotThereIsNotFound) {
  const TempFolder folder;
  EXPECT_THAT(write_file(folder / "no/a.txt", "x"), FailsWith(ErrorCode::NotFound, "no/a.txt"));
}

TEST(File, KeepsItsOldContentsWhenTheDiskIsFull) {
  const TempFolder folder;
  folder.write("a.txt", "old");
  // The temporary name leads to a device on which every write says "no space left".
  std::filesystem::create_symlink("/dev/full", temporary_name(folder / "a.txt"));
  EXPECT_THAT(write_file(folder / "a.txt", "new"), FailsWith(ErrorCode::Io, "No space left on device"));
  EXPECT_THAT(read_file(folder / "a.txt"), IsOkAnd(Eq("old")));
  EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
}

// Lets no file of this process grow beyond `bytes` while it lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(File, CutShortInTheMiddleLeavesTheOldOne) {
  const TempFolder folder;
  folder.write("a.txt", "old");
  Result<void> written;
  {
    const FileSizeLimit limit(4096);
    written = write_file(folder / "a.txt", std::string(10'000, 'x'));
  }
  EXPECT_THAT(written, FailsWith(ErrorCode::Io, "a.txt"));
  EXPECT_THAT(read_file(folder / "a.txt"), IsOkAnd(Eq("old")));
  EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
}

// The administrator may write everywhere: become nobody for a moment.
class Unprivileged {
 public:
  Unprivileged() : was_root_(geteuid() == 0 && seteuid(65534) == 0) {}
  ~Unprivileged() {
    if (was_root_ && seteuid(0) != 0) std::abort();
  }
  Unprivileged(const Unprivileged&) = delete;
  Unprivileged& operator=(const Unprivileged&) = delete;

 private:
  bool was_root_;
};

TEST(File, InAnUnwritableFolderIsRefusedAndLeavesTheOldOne) {
  const TempFolder folder;
  folder.write("a.txt", "old");
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  Result<void> written;
  {
    const Unprivileged nobody;
    written = write_file(folder / "a.txt", "new");
  }
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  EXPECT_THAT(written, FailsWith(ErrorCode::Io, "Permission denied"));
  EXPECT_THAT(read_file(folder / "a.txt"), IsOkAnd(Eq("old")));
}

TEST(TemporaryName, IsHiddenBesideTheFileAndKeepsTheType) {
  EXPECT_EQ(temporary_name("takes/a.mkv"), "takes/.a.tmp.mkv");
  EXPECT_EQ(temporary_name("left.frames.csv"), ".left.frames.tmp.csv");
}

}  // namespace
}  // namespace floatstage
