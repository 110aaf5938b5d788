// A child that decodes foreign files, in the hands of somebody who took its decoder over.

#include "core/confined.h"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/check.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"
#include "core/working_on.h"
#include "tests/support/matchers.h"
#include "tests/support/sanitized.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

Result<void> listen_to_nothing(std::string_view) { return {}; }

/// What becomes of a decoder that does this while it decodes "film.mp4", and may write in `folder`.
Result<std::string> decoding(const std::function<void()>& hostile, const fs::path& folder = {}) {
  Confinement limits{.what = "the calibration", .decode_seconds = 0.3};
  if (!folder.empty()) limits.writable = {folder};
  return run_confined(
      limits,
      [&](const Tell&) -> Result<std::string> {
        const WorkingOn here("film.mp4");
        hostile();
        return std::string("lived");
      },
      listen_to_nothing);
}

const char* const kStopped =
    "film.mp4: what decodes it wanted the network, another program or another process";

TEST(ConfinedChild, GivesItsResultAndItsErrorAndTellsInOrder) {
  std::string told;
  const Result<std::string> result = run_confined(
      {.what = "x"},
      [](const Tell& tell) -> Result<std::string> {
        for (int i = 0; i < 1000; ++i) tell(text(i, ','));
        return std::string(50'000'000, 'p');
      },
      [&](std::string_view word) -> Result<void> {
        told += word;
        return {};
      });
  ASSERT_THAT(result, IsOk());
  EXPECT_EQ(*result, std::string(50'000'000, 'p'));
  std::string expected;
  for (int i = 0; i < 1000; ++i) expected += text(i, ',');
  EXPECT_EQ(told, expected);
  EXPECT_THAT(
      run_confined(
          {.what = "x"}, [](const Tell&) { return fail(ErrorCode::NotFound, "no film"); }, listen_to_nothing),
      FailsWith(ErrorCode::NotFound, "no film"));
}

TEST(ConfinedChild, HasThreads) {
  parallel_for(8, 2, [](std::size_t) {});  // the parent's, which the child does not have
  EXPECT_THAT(run_confined(
                  {.what = "x"},
                  [](const Tell&) -> Result<std::string> {
                    std::atomic<int> there = 0;
                    // Each waits for the other: one thread alone would never end.
                    parallel_for(2, 2, [&](std::size_t) {
                      ++there;
                      while (there < 2) std::this_thread::yield();
                    });
                    return std::string();
                  },
                  listen_to_nothing),
              IsOk());
}

TEST(ConfinedChild, ReachesNoNetwork) {
  EXPECT_THAT(decoding([] { ::socket(AF_INET, SOCK_STREAM, 0); }), FailsWith(ErrorCode::BadData, kStopped));
  EXPECT_THAT(decoding([] { ::socket(AF_UNIX, SOCK_DGRAM, 0); }), FailsWith(ErrorCode::BadData, kStopped));
}

TEST(ConfinedChild, HasNoneOfItsParentsConnections) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  const int ours = ::dup2(ends[0], 100);
  const auto result = decoding([&] { FLOATSTAGE_CHECK(::write(ours, "x", 1) < 0, "it has them"); });
  EXPECT_THAT(result, IsOk());
  for (const int end : {ends[0], ends[1], ours}) ::close(end);
}

TEST(ConfinedChild, StartsNoOtherProgramOrProcess) {
  EXPECT_THAT(decoding([] { ::execl("/bin/true", "true", nullptr); }),
              FailsWith(ErrorCode::BadData, kStopped));
  EXPECT_THAT(decoding([] { static_cast<void>(::fork()); }), FailsWith(ErrorCode::BadData, kStopped));
  EXPECT_THAT(decoding([] { FLOATSTAGE_CHECK(std::system("true") != 0, "it ran"); }),
              FailsWith(ErrorCode::BadData, kStopped));
}

TEST(ConfinedChild, ReachesNoOtherProcess) {
  const pid_t us = ::getpid();
  EXPECT_THAT(decoding([&] { ::kill(us, SIGTERM); }), FailsWith(ErrorCode::BadData, kStopped));
  EXPECT_THAT(decoding([&] { ::ptrace(PTRACE_ATTACH, us, nullptr, nullptr); }),
              FailsWith(ErrorCode::BadData, kStopped));
}

TEST(ConfinedChild, WritesInItsFolderAndNowhereElse) {
  const TempFolder folder;
  fs::create_directories(folder / "mine");
  folder.write("thesis.txt", "all of it");
  const fs::path thesis = folder / "thesis.txt";
  ::chmod(thesis.c_str(), 0640);
  const auto result = decoding(
      [&] {
        FLOATSTAGE_CHECK(write_file(folder / "mine" / "picture", "pixels").has_value(), "its own folder");
        FLOATSTAGE_CHECK(::mkdir((folder / "mine" / "sub").c_str(), 0777) == 0, "its own folder");
        FLOATSTAGE_CHECK(read_file(thesis).has_value(), "reading");
        FLOATSTAGE_CHECK(!write_file(folder / "other", "x").has_value(), "a new file elsewhere");
        FLOATSTAGE_CHECK(::open(thesis.c_str(), O_WRONLY) < 0, "to write");
        FLOATSTAGE_CHECK(::open(thesis.c_str(), O_RDWR | O_APPEND) < 0, "to append");
        FLOATSTAGE_CHECK(::open(thesis.c_str(), O_RDONLY | O_TRUNC) < 0, "to empty by opening");
        FLOATSTAGE_CHECK(::truncate(thesis.c_str(), 0) != 0, "to empty");
        FLOATSTAGE_CHECK(::unlink(thesis.c_str()) != 0, "to remove");
        FLOATSTAGE_CHECK(::rename(thesis.c_str(), (folder / "mine" / "t").c_str()) != 0, "to take away");
        FLOATSTAGE_CHECK(::rename((folder / "mine" / "picture").c_str(), thesis.c_str()) != 0, "to replace");
        FLOATSTAGE_CHECK(::chmod(thesis.c_str(), 0777) != 0, "to open to all");
        FLOATSTAGE_CHECK(::symlink("/etc", (folder / "mine" / "link").c_str()) != 0, "to lead out");
        FLOATSTAGE_CHECK(::link(thesis.c_str(), (folder / "mine" / "hard").c_str()) != 0, "to lead out");
      },
      folder / "mine");
  EXPECT_THAT(result, IsOk());
  EXPECT_EQ(*read_file(thesis), "all of it");
  struct stat status = {};
  ::stat(thesis.c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
  EXPECT_EQ(*read_file(folder / "mine" / "picture"), "pixels");
}

TEST(ConfinedChild, ThatEatsMemoryIsStoppedBeforeTheMachineFeelsIt) {
  if (kSanitized) GTEST_SKIP() << "sanitizers need terabytes of addresses";
  const auto eat = [] {
    std::vector<std::string> meal;
    for (int i = 0; i < 64; ++i) meal.emplace_back(std::size_t{1} << 30, 'x');
  };
  EXPECT_THAT(run_confined(
                  {.what = "x", .memory = std::uint64_t{256} << 20},
                  [&](const Tell&) -> Result<std::string> {
                    const WorkingOn here("bomb.png");
                    eat();
                    return std::string();
                  },
                  listen_to_nothing),
              FailsWith(ErrorCode::BadData, "bomb.png: decoding it takes more memory"));
  EXPECT_THAT(run_confined(
                  {.what = "x"},
                  [&](const Tell&) -> Result<std::string> {
                    confine_memory(std::uint64_t{64} << 20);
                    const WorkingOn here("bomb.png");
                    eat();
                    return std::string();
                  },
                  listen_to_nothing),
              FailsWith(ErrorCode::BadData, "bomb.png: decoding it takes more memory"));
}

TEST(ConfinedChild, ThatSpinsIsEndedByTheProcessorTimeOfOneFile) {
  EXPECT_THAT(decoding([] {
                for (;;) static_cast<void>(std::clock());
              }),
              FailsWith(ErrorCode::BadData, "film.mp4: not decoded after 0.3 s"));
}

TEST(ConfinedChild, MayTakeItsTimeFromFileToFile) {
  EXPECT_THAT(run_confined(
                  {.what = "x", .decode_seconds = 0.3},
                  [](const Tell&) -> Result<std::string> {
                    const auto half = [] {
                      for (const std::clock_t until = std::clock() + CLOCKS_PER_SEC / 5;
                           std::clock() < until;)
                        continue;
                    };
                    for (int i = 0; i < 3; ++i) {
                      half();  // of one's own
                      const WorkingOn here("film.mp4");
                      half();
                    }
                    return std::string();
                  },
                  listen_to_nothing),
              IsOk());
}

TEST(ConfinedChild, ThatCrashesNamesTheFileOfTheThreadThatDid) {
  if (kSanitized) GTEST_SKIP() << "sanitizers end a crash in their own way";
  EXPECT_THAT(decoding([] { ::raise(SIGSEGV); }),
              FailsWith(ErrorCode::BadData, "film.mp4: what decodes it crashed"));
  EXPECT_THAT(decoding([] { std::abort(); }),
              FailsWith(ErrorCode::BadData, "film.mp4: what decodes it crashed"));
  EXPECT_THAT(decoding([] { ::_exit(0); }), FailsWith(ErrorCode::BadData, "film.mp4: what decodes it ended"));
  const auto two = run_confined(
      {.what = "x"},
      [](const Tell&) -> Result<std::string> {
        const WorkingOn here("innocent.png");
        std::thread([] {
          const WorkingOn there("guilty.png");
          ::raise(SIGFPE);
        }).join();
        return std::string();
      },
      listen_to_nothing);
  ASSERT_THAT(two, FailsWith(ErrorCode::BadData, "guilty.png: what"));
  EXPECT_EQ(two.error().message.find("innocent"), std::string::npos);
}

TEST(ConfinedChild, OfNoFileIsNamedAfterItsWork) {
  if (kSanitized) GTEST_SKIP() << "sanitizers end a crash in their own way";
  EXPECT_THAT(run_confined(
                  {.what = "the calibration"},
                  [](const Tell&) -> Result<std::string> {
                    ::raise(SIGSEGV);
                    return std::string();
                  },
                  listen_to_nothing),
              FailsWith(ErrorCode::BadData, "the calibration: what decodes it crashed"));
}

TEST(ConfinedChild, ThatTalksNonsenseIsEnded) {
  EXPECT_THAT(decoding([] {
                const std::string noise(100'000, '\xee');
                for (;;)
                  if (::write(3, noise.data(), noise.size()) < 0) ::_exit(1);
              }),
              FailsWith(ErrorCode::BadData, "film.mp4: what decodes it ended without a result"));
}

TEST(ConfinedChild, OurOwnMistakesStayOurs) {
  EXPECT_THROW(static_cast<void>(decoding([] { FLOATSTAGE_CHECK(false, "ours"); })), CheckFailure);
}

TEST(ConfinedChild, EndsWhenItsParentHasEnough) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(run_confined(
                  {.what = "x"},
                  [](const Tell&) -> Result<std::string> {
                    for (;;) ::pause();
                  },
                  [](std::string_view) -> Result<void> { return fail(ErrorCode::Cancelled, "enough"); }),
              FailsWith(ErrorCode::Cancelled, "enough"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

TEST(ConfinedChild, HasTheTimeToEndInOrderThatItIsGiven) {
  const auto enough = [](std::string_view) -> Result<void> { return fail(ErrorCode::Cancelled, "enough"); };
  const auto ends = [](const Tell& tell) -> Result<std::string> {
    while (!asked_to_end()) tell("and so on");
    return fail(ErrorCode::Cancelled, "what was done is kept");
  };
  EXPECT_THAT(run_confined({.what = "x", .ending_seconds = 20}, ends, enough),
              FailsWith(ErrorCode::Cancelled, "what was done is kept"));
  EXPECT_THAT(run_confined({.what = "x"}, ends, enough), FailsWith(ErrorCode::Cancelled, "enough"));
  const auto does_not = [](const Tell&) -> Result<std::string> {
    for (;;) ::pause();
  };
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(run_confined({.what = "x", .ending_seconds = 0.3}, does_not, enough),
              FailsWith(ErrorCode::Cancelled, "enough"));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_FALSE(asked_to_end()) << "here is no child";
}

}  // namespace
}  // namespace floatstage
