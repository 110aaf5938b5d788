#include "core/claim.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "tests/support/child_process.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

/// A process that holds what `claim` claims until it is killed.
template <class Claiming>
ChildProcess holder(const Claiming& claim) {
  return ChildProcess([&claim](const std::function<void()>& report) {
    const auto held = claim();
    if (!held) return 1;
    report();
    ::pause();
    return 0;
  });
}

TEST(NewFolder, IsOneProcesssAtATime) {
  const TempFolder folder;
  ChildProcess other = holder([&] { return claim_new_folder(folder / "t"); });
  ASSERT_TRUE(other.wait_for_reports(1));
  EXPECT_THAT(claim_new_folder(folder / "t"),
              FailsWith(ErrorCode::AlreadyExists, "is being written by another run"));
  other.kill();
  other.wait();
  const Result<NewFolder> ours = claim_new_folder(folder / "t");
  ASSERT_THAT(ours, IsOk()) << "a claim ends with its process, and what it left is an empty folder";
  EXPECT_FALSE(ours->made);
}

TEST(NewFolder, IsMadeWithThoseAboveIt) {
  const TempFolder folder;
  const Result<NewFolder> ours = claim_new_folder(folder / "a" / "b");
  ASSERT_THAT(ours, IsOk());
  EXPECT_TRUE(ours->made);
  EXPECT_TRUE(fs::is_directory(folder / "a" / "b"));
}

TEST(NewFolder, HoldsNothingYet) {
  const TempFolder folder;
  fs::create_directory(folder / "t");
  folder.write("t/mine.txt", "mine");
  EXPECT_THAT(claim_new_folder(folder / "t"), FailsWith(ErrorCode::AlreadyExists, "is not empty"));
  folder.write("file", "");
  EXPECT_THAT(claim_new_folder(folder / "file"), FailsWith(ErrorCode::Io, "file"));
}

// Writers that fail remove what they made while others are on their way in.
TEST(NewFolder, RacedForByManyHasOneHolderAtATime) {
  const TempFolder folder;
  std::vector<std::unique_ptr<ChildProcess>> children;
  for (int i = 0; i < 4; ++i)
    children.push_back(std::make_unique<ChildProcess>([&](const std::function<void()>&) {
      for (int round = 0; round < 200; ++round) {
        const Result<NewFolder> ours = claim_new_folder(folder / "t");
        if (!ours && ours.error().code != ErrorCode::AlreadyExists) return 2;
        if (!ours) continue;
        // Nobody else is in here: a file of this name is new, and ours alone to remove.
        if (::mkdir((folder / "t" / "inside").c_str(), 0700) != 0) return 3;
        if (::rmdir((folder / "t" / "inside").c_str()) != 0) return 4;
        if (::rmdir((folder / "t").c_str()) != 0) return 5;
      }
      return 0;
    }));
  for (const auto& child : children) EXPECT_EQ(child->wait(), 0);
}

TEST(TemporaryFile, IsClearedOfWhatAKilledRunLeft) {
  const TempFolder folder;
  folder.write(".film.tmp.mp4", "half a film");
  const Result<Claim> ours = claim_temporary_file(folder / "film.mp4");
  ASSERT_THAT(ours, IsOk());
  EXPECT_THAT(read_file(folder / ".film.tmp.mp4"), IsOkAnd(IsEmpty()));
}

TEST(TemporaryFile, OfSomebodyWhoIsWritingIsLeftAlone) {
  const TempFolder folder;
  ChildProcess other = holder([&] {
    Result<Claim> held = claim_temporary_file(folder / "film.mp4");
    folder.write(".film.tmp.mp4", "half a film");
    return held;
  });
  ASSERT_TRUE(other.wait_for_reports(1));
  EXPECT_THAT(claim_temporary_file(folder / "film.mp4"), FailsWith(ErrorCode::AlreadyExists, "film.mp4"));
  EXPECT_THAT(read_file(folder / ".film.tmp.mp4"), IsOkAnd(testing::Eq("half a film")));
  other.kill();
  other.wait();
}

TEST(TemporaryFile, ReplacesALinkInsteadOfFollowingIt) {
  const TempFolder folder;
  folder.write("precious.txt", "precious");
  fs::create_symlink(folder / "precious.txt", folder / ".film.tmp.mp4");
  ASSERT_THAT(claim_temporary_file(folder / "film.mp4"), IsOk());
  EXPECT_THAT(read_file(folder / "precious.txt"), IsOkAnd(testing::Eq("precious")));
  EXPECT_FALSE(fs::is_symlink(folder / ".film.tmp.mp4"));
}

TEST(TemporaryFile, IsNotBegunForWhatIsThereAlready) {
  const TempFolder folder;
  folder.write("film.mp4", "a film");
  EXPECT_THAT(claim_temporary_file(folder / "film.mp4"),
              FailsWith(ErrorCode::AlreadyExists, "never overwritten"));
  EXPECT_THAT(folder.names(), ElementsAre("film.mp4"));
  EXPECT_THAT(claim_temporary_file(folder / "film.mp4", IfThere::Replace), IsOk());
}

TEST(TemporaryFolder, IsClearedAndALinkIsNotFollowed) {
  const TempFolder folder;
  fs::create_directory(folder / ".t.tmp");
  fs::create_directory(folder / "precious");
  folder.write(".t.tmp/half.mkv", "half");
  folder.write("precious/a.txt", "precious");
  fs::create_symlink(folder / "precious", folder / ".t.tmp" / "link");
  ASSERT_THAT(claim_temporary_folder(folder / "t"), IsOk());
  EXPECT_TRUE(fs::is_empty(folder / ".t.tmp"));
  fs::remove(folder / ".t.tmp");
  fs::create_directory_symlink(folder / "precious", folder / ".t.tmp");
  ASSERT_THAT(claim_temporary_folder(folder / "t"), IsOk());
  EXPECT_TRUE(fs::exists(folder / "precious" / "a.txt"));
}

TEST(AFolderInUse, IsWaitedForUntilItIsFree) {
  const TempFolder folder;
  const auto forever = [] { return true; };
  ChildProcess other = holder([&] { return wait_for_folder(folder.path(), forever); });
  ASSERT_TRUE(other.wait_for_reports(1));
  int asked = 0;
  EXPECT_THAT(wait_for_folder(folder.path(), [&] { return ++asked < 3; }),
              FailsWith(ErrorCode::Cancelled, "while another run worked on"));
  other.kill();
  other.wait();
  EXPECT_THAT(wait_for_folder(folder.path(), [] { return false; }), IsOk());
  EXPECT_THAT(wait_for_folder(folder / "none", forever), FailsWith(ErrorCode::NotFound, "none"));
}

TEST(RenameNew, NeverReplacesWhatIsThere) {
  const TempFolder folder;
  folder.write("a", "a");
  folder.write("b", "b");
  EXPECT_THAT(rename_new(folder / "a", folder / "b"),
              FailsWith(ErrorCode::AlreadyExists, "never overwritten"));
  EXPECT_THAT(read_file(folder / "b"), IsOkAnd(testing::Eq("b")));
  EXPECT_THAT(rename_new(folder / "a", folder / "c"), IsOk());
  EXPECT_THAT(folder.names(), ElementsAre("b", "c"));
  EXPECT_THAT(rename_new(folder / "none", folder / "d"), FailsWith(ErrorCode::NotFound, "d"));
}

}  // namespace
}  // namespace floatstage
