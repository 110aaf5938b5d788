#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <regex>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"
#include "tests/farm/quoted.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

// The Debian package from its making to its removal (docs/packaging.md), in a root that holds Debian's
// essential packages and its dependencies.
namespace floatstage {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;

// What systemd would hear of a daemon: a socket that waits for READY=1.
class NoticeSocket {
 public:
  explicit NoticeSocket(const fs::path& path) : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {.sun_family = AF_UNIX, .sun_path = {}};
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
    ::chmod(path.c_str(), 0666);
  }
  ~NoticeSocket() { ::close(fd_); }
  NoticeSocket(const NoticeSocket&) = delete;
  NoticeSocket& operator=(const NoticeSocket&) = delete;

  bool hears_ready(std::chrono::seconds patience) const {
    const timeval wait = {.tv_sec = patience.count(), .tv_usec = 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
    char words[512];
    for (ssize_t n; (n = ::recv(fd_, words, sizeof words, 0)) > 0;)
      if (std::string_view(words, static_cast<std::size_t>(n)).find("READY=1") != std::string_view::npos)
        return true;
    return false;
  }

 private:
  int fd_;
};

class DebianPackage : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (::geteuid() != 0) {
      if (on_ci()) FAIL() << "a root of its own takes root's rights";
      GTEST_SKIP() << "a root of its own takes root's rights";
    }
    const Ended packed = run_command("cd " + quoted(folder_.path()) + " && cpack --config " +
                                     FLOATSTAGE_BUILD_DIR "/CPackConfig.cmake -B . && ls *.deb");
    ASSERT_EQ(packed.code, 0) << packed.output;
    for (const fs::directory_entry& file : fs::directory_iterator(folder_.path()))
      if (file.path().extension() == ".deb") deb_ = file.path();
    root_ = folder_ / "root";
    const Ended made =
        run_command(text("unshare --mount ", source_folder().string(), "/tests/farm/bare_root.sh ",
                         GetParam(), " ", quoted(root_), " ", quoted(deb_)));
    ASSERT_EQ(made.code, 0) << made.output;
  }

  Ended in_root(const std::string& command) const {
    return run_command(
        text(source_folder().string(), "/tests/farm/in_root.sh ", quoted(root_), " ", command));
  }
  Ended as_floatstage(const std::string& command) const {
    return in_root(
        "setpriv --reuid floatstage --regid floatstage --init-groups --no-new-privs env HOME=/tmp " +
        command);
  }

  // Every name in the root that a package may be blamed for.
  std::set<std::string> names() const {
    std::set<std::string> all;
    const std::regex others(
        "/(proc|dev|run|tmp|var/lib/dpkg|var/log|var/cache)(/.*)?|/etc/[a-z.]+(-|\\.lock)");
    for (auto it = fs::recursive_directory_iterator(root_); it != fs::recursive_directory_iterator(); ++it) {
      const std::string name =
          "/" + fs::relative(it->path().parent_path(), root_).string() + "/" + it->path().filename().string();
      const std::string clean = name.starts_with("/./") ? name.substr(2) : name;
      if (it->is_symlink() || std::regex_match(clean, others)) it.disable_recursion_pending();
      if (!std::regex_match(clean, others)) all.insert(clean);
    }
    return all;
  }

  // Runs the unit's ExecStart as its user until it says that it is ready, and ends it as systemd does.
  void start_and_stop_the_daemon() const {
    const Result<std::string> unit = read_file(root_ / "usr/lib/systemd/system/floatstage-capture.service");
    ASSERT_THAT(unit, IsOk());
    std::smatch start;
    ASSERT_TRUE(std::regex_search(*unit, start, std::regex("\nExecStart=(.*)\n")));
    EXPECT_THAT(*unit, HasSubstr("\nUser=floatstage\n"));
    const NoticeSocket notices(root_ / "run/notify");
    const fs::path stop = root_ / "run/stop";
    std::future<Ended> daemon = std::async(std::launch::async, [&] {
      return in_root(
          text("sh -c 'setpriv --reuid floatstage --regid floatstage --init-groups --no-new-privs "
               "env NOTIFY_SOCKET=/run/notify ",
               start[1].str(),
               " & while [ ! -e /run/stop ] && kill -0 $!; do sleep 0.1; done; kill $!; wait $!'"));
    });
    const bool ready = notices.hears_ready(std::chrono::seconds(300));
    std::ofstream(stop) << "now";
    const Ended ended = daemon.get();
    EXPECT_TRUE(ready) << ended.output;
    EXPECT_EQ(ended.code, 0) << ended.output;
  }

  TempFolder folder_;
  fs::path deb_, root_;
};

TEST_P(DebianPackage, InstallsRunsAndGoesAndLeavesNothingButTakes) {
  const std::set<std::string> before = names();
  const Ended installed = in_root("dpkg --install /tmp/" + deb_.filename().string());
  ASSERT_EQ(installed.code, 0) << installed.output;
  EXPECT_THAT(names(),
              testing::IsSupersetOf(
                  {"/usr/bin/floatstage", "/usr/share/man/man1/floatstage.1.gz",
                   "/usr/share/bash-completion/completions/floatstage",
                   "/usr/lib/python3/dist-packages/floatstage.py", "/usr/lib/sysctl.d/60-floatstage.conf",
                   "/usr/lib/udev/rules.d/60-floatstage.rules", "/usr/share/doc/floatstage/copyright"}));

  const Ended demo =
      as_floatstage("floatstage demo -o /var/lib/floatstage/takes/demo --camera-count 4 --frame-count 2");
  EXPECT_EQ(demo.code, 0) << demo.output;
  EXPECT_TRUE(fs::exists(root_ / "var/lib/floatstage/takes/demo/freeview.mp4")) << demo.output;
  start_and_stop_the_daemon();

  for (const char* step : {"dpkg --remove floatstage", "dpkg --purge floatstage"}) {
    const Ended gone = in_root(step);
    EXPECT_EQ(gone.code, 0) << gone.output;
  }
  std::set<std::string> left;
  for (const std::string& name : names())
    if (!before.contains(name) && name != "/var/lib/floatstage" &&
        !name.starts_with("/var/lib/floatstage/takes"))
      left.insert(name);
  EXPECT_THAT(left, IsEmpty());
  EXPECT_TRUE(fs::exists(root_ / "var/lib/floatstage/takes/demo/freeview.mp4"));
  const Result<std::string> accounts = read_file(root_ / "etc/passwd");
  EXPECT_THAT(accounts, IsOkAnd(HasSubstr("\nfloatstage:")))
      << "takes have an owner as long as they are there";
}

// Of this system's own packages always; as the mirror has them in the long form, which wants a network.
std::vector<const char*> roots() {
  return wants_long_tests() ? std::vector{"installed", "mirror"} : std::vector{"installed"};
}
INSTANTIATE_TEST_SUITE_P(Roots, DebianPackage, testing::ValuesIn(roots()),
                         [](const auto& where) { return std::string(where.param); });

}  // namespace
}  // namespace floatstage
