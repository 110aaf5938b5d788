#include "core/file.h"

#include <csignal>
#include <cstdlib>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/parallel.h"
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

TEST(File, ThatIsAPipeOrADeviceIsRefusedWithoutWaiting) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(read_file(folder / "pipe"), FailsWith(ErrorCode::Io, "it is a pipe, not a file"));
  EXPECT_THAT(read_file("/dev/zero"), FailsWith(ErrorCode::Io, "it is a device, not a file"));
}

TEST(File, LargerThanAllOfItsKindIsRefusedBeforeItIsRead) {
  const TempFolder folder;
  folder.write("a.txt", std::string(3 << 20, 'x'));
  EXPECT_THAT(read_file(folder / "a.txt", 2 << 20), FailsWith(ErrorCode::BadData, "more than 2 MiB"));
  EXPECT_THAT(read_file(folder / "a.txt", 3 << 20), IsOk());
}

TEST(File, WithoutASizeIsReadToItsEnd) {
  EXPECT_THAT(read_file("/proc/self/status"), IsOkAnd(testing::HasSubstr("Threads:")));
}

TEST(File, IsNotWrittenThroughALinkThatSomebodyLeft) {
  const TempFolder folder;
  folder.write("precious.txt", "precious");
  std::filesystem::create_symlink(folder / "precious.txt", temporary_name(folder / "a.txt"));
  ASSERT_THAT(write_file(folder / "a.txt", "new"), IsOk());
  EXPECT_THAT(read_file(folder / "precious.txt"), IsOkAnd(Eq("precious")));
}

TEST(File, WrittenByManyAtOnceIsOneOfTheirs) {
  const TempFolder folder;
  const auto text_of = [](std::size_t writer) {
    return std::string(50'000, static_cast<char>('a' + writer));
  };
  for (int round = 0; round < 20; ++round) {
    std::vector<Result<void>> written(4);
    parallel_for(written.size(), 4,
                 [&](std::size_t i) { written[i] = write_file(folder / "a.txt", text_of(i)); });
    for (const Result<void>& ok : written) EXPECT_THAT(ok, IsOk());
    const Result<std::string> bytes = read_file(folder / "a.txt");
    ASSERT_THAT(bytes, IsOk());
    EXPECT_EQ(*bytes, text_of(static_cast<std::size_t>(bytes->front() - 'a')));
  }
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

TEST(TemporaryName, IsKnownAgainWithAndWithoutNumbers) {
  for (const char* half :
       {"m/.000012.tmp.png", ".a.tmp.mkv", ".left.frames.tmp.csv", "m/.a.tmp-12-3.png", ".T.tmp"})
    EXPECT_TRUE(is_temporary(half)) << half;
  for (const char* file : {"000012.png", "a.tmp.png", ".hidden.png", ".a.tmpx.png", ".a.tmp-x.png"})
    EXPECT_FALSE(is_temporary(file)) << file;
}

}  // namespace
}  // namespace floatstage
