// A markerless calibration that is interrupted while COLMAP works, as by Ctrl-C: nothing of it stays in the
// temporary folder, and no program of it goes on.

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"
#include "core/png.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

// The program on its own, with a COLMAP that says that it works and then sleeps.
class Interrupted : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"tmp", "bin"}) ASSERT_THAT(make_folder(folder_ / name), IsOk());
    const fs::path colmap = folder_.write(
        "bin/colmap", "#!/bin/sh\necho $$ > " + (folder_ / "works").string() + "\nexec sleep 600\n");
    fs::permissions(colmap, fs::perms::owner_all);
    for (const char* name : {"a.png", "b.png"}) {
      Image picture(64, 48, 1);
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
          *picture.at(x, y) = static_cast<std::uint8_t>((x * 37 + y * 101 + name[0]) % 251);
      ASSERT_THAT(save_png(picture, folder_ / name), IsOk());
    }
    folder_.write("s.toml",
                  "[markerless]\nlens = \"shared\"\nbetween = [\"a\", \"b\"]\ndistance = 1\n"
                  "[[cameras]]\nscene = \"{serial}.png\"\n");
  }

  pid_t start() {
    const pid_t child = fork();
    if (child != 0) return child;
    setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
    setenv("PATH", ((folder_ / "bin").string() + ":" + std::getenv("PATH")).c_str(), 1);
    const int quiet = open("/dev/null", O_RDWR | O_CLOEXEC);
    dup2(quiet, 1), dup2(quiet, 2);
    const std::string session = (folder_ / "s.toml").string();
    execl(FLOATSTAGE_PROGRAM, FLOATSTAGE_PROGRAM, "calibrate", session.c_str(), nullptr);
    _exit(127);
  }
  bool works() const { return fs::exists(folder_ / "works"); }
  bool nothing_left() const { return fs::is_empty(folder_ / "tmp"); }
  pid_t colmap() const { return std::atoi(read_file(folder_ / "works").value().c_str()); }

  TempFolder folder_;
};

TEST_F(Interrupted, BySignalLeavesNothingInTheTemporaryFolder) {
  for (const int signal : {SIGINT, SIGTERM}) {
    fs::remove(folder_ / "works");
    const pid_t run = start();
    ASSERT_TRUE(eventually([&] { return works() && !read_file(folder_ / "works").value().empty(); }));
    EXPECT_FALSE(nothing_left()) << "it works there";
    const pid_t program = colmap();
    kill(run, signal);
    int status = 0;
    ASSERT_EQ(waitpid(run, &status, 0), run);
    EXPECT_TRUE(WIFEXITED(status)) << "it ended by itself";
    EXPECT_TRUE(nothing_left());
    EXPECT_NE(kill(program, 0), 0) << "COLMAP was ended, too";
  }
}

// As timeout(1) and supervisors do it, who signal a process and then its group.
TEST_F(Interrupted, TwiceAtOnceEndsByItselfAllTheSame) {
  const pid_t run = start();
  ASSERT_TRUE(eventually([&] { return works() && !read_file(folder_ / "works").value().empty(); }));
  kill(run, SIGINT);
  kill(run, SIGTERM);
  int status = 0;
  ASSERT_EQ(waitpid(run, &status, 0), run);
  EXPECT_TRUE(WIFEXITED(status)) << "not by signal " << WTERMSIG(status);
  EXPECT_TRUE(nothing_left());
}

TEST_F(Interrupted, ByAKillLeavesNothingForTheNextRun) {
  const pid_t run = start();
  ASSERT_TRUE(eventually([&] { return works() && !read_file(folder_ / "works").value().empty(); }));
  kill(run, SIGKILL);
  waitpid(run, nullptr, 0);
  kill(colmap(), SIGKILL);
  EXPECT_FALSE(nothing_left()) << "who is killed cannot tidy up";
  fs::remove(folder_ / "works");
  const pid_t next = start();
  ASSERT_TRUE(eventually([&] { return works() && !read_file(folder_ / "works").value().empty(); }));
  kill(next, SIGTERM);
  waitpid(next, nullptr, 0);
  EXPECT_TRUE(nothing_left());
}

}  // namespace
}  // namespace floatstage::apps
