#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "apps/check/machine.h"
#include "core/text.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Verdict = Finding::Verdict;

/// A machine of files.
class AMachine : public testing::Test {
 protected:
  void says(const std::string& file, const std::string& line) {
    std::filesystem::create_directories((root_ / file).parent_path());
    root_.write(file, line + "\n");
  }
  void interface(const std::string& name, const std::string& state, int mtu) {
    says("sys/class/net/" + name + "/operstate", state);
    says("sys/class/net/" + name + "/mtu", std::to_string(mtu));
  }
  TempFolder root_;
};

TEST_F(AMachine, NeedsReceiveBuffersForFourPictures) {
  const Finding unknown = look_at_receive_buffers(root_.path(), 640 * 480);
  EXPECT_EQ(unknown.verdict, Verdict::Warn);
  EXPECT_THAT(unknown.what, HasSubstr("cannot be read"));
  says("proc/sys/net/core/rmem_max", "33554432");
  EXPECT_EQ(look_at_receive_buffers(root_.path(), 640 * 480).verdict, Verdict::Pass);
  says("proc/sys/net/core/rmem_max", "212992");
  const Finding few = look_at_receive_buffers(root_.path(), 640 * 480);
  EXPECT_EQ(few.verdict, Verdict::Fail) << "not one picture fits";
  EXPECT_THAT(few.what, HasSubstr("sysctl -w net.core.rmem_max=1228800"));
  says("proc/sys/net/core/rmem_max", "400000");
  EXPECT_EQ(look_at_receive_buffers(root_.path(), 640 * 480).verdict, Verdict::Warn);
}

TEST_F(AMachine, IsAdvisedJumboFramesOnEachInterfaceThatIsUp) {
  interface("lo", "unknown", 65536);
  EXPECT_THAT(look_at_mtu(root_.path()).front().what, HasSubstr("no interface but the loopback"));
  interface("eth0", "up", 1500);
  interface("eth1", "up", 9000);
  interface("eth2", "down", 1500);
  const std::vector<Finding> found = look_at_mtu(root_.path());
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].verdict, Verdict::Warn);
  EXPECT_THAT(found[0].what, HasSubstr("ip link set dev eth0 mtu 9000"));
  EXPECT_EQ(found[1].verdict, Verdict::Pass);
}

TEST_F(AMachine, NeedsAHardwareClockAndItsKeeperForPtp) {
  EXPECT_THAT(look_at_ptp(root_.path()).what, HasSubstr("no network card has a hardware clock"));
  says("sys/class/ptp/ptp0/clock_name", "igb");
  EXPECT_THAT(look_at_ptp(root_.path()).what, HasSubstr("ptp0 (igb), and no ptp4l runs"));
  says("proc/77/comm", "ptp4l");
  EXPECT_EQ(look_at_ptp(root_.path()).verdict, Verdict::Pass);
}

TEST_F(AMachine, IsToldAboutAClockThatIsSlowToRead) {
  const std::string file = "sys/devices/system/clocksource/clocksource0/current_clocksource";
  says(file, "tsc");
  EXPECT_EQ(look_at_clock(root_.path())[0].verdict, Verdict::Pass);
  says(file, "hpet");
  EXPECT_EQ(look_at_clock(root_.path())[0].verdict, Verdict::Warn);
  EXPECT_EQ(look_at_clock(root_.path()).size(), 2u);
}

TEST(Check, MeasuresTheDiskAgainstWhatIsNeeded) {
  const TempFolder folder;
  EXPECT_EQ(look_at_disk(folder.path(), 1, "nobody").verdict, Verdict::Pass);
  const Finding slow = look_at_disk(folder.path(), 1e15, "a thousand cameras");
  EXPECT_EQ(slow.verdict, Verdict::Fail);
  EXPECT_THAT(slow.what, HasSubstr("a thousand cameras need 1e+09 MB a second: record to a faster disk"));
  EXPECT_THAT(folder.names(), ElementsAre()) << "nothing is left behind";
  EXPECT_EQ(look_at_disk(folder / "none", 1, "x").verdict, Verdict::Fail);
}

TEST(Check, JudgesADiskByItsSpeedAndItsRoom) {
  const auto judged = [](double rate, std::uint64_t room, double needed) {
    return judge_disk("/takes", {rate, room}, needed, "the cameras");
  };
  EXPECT_EQ(judged(200e6, 1'000'000'000'000, 100e6).verdict, Verdict::Pass);
  EXPECT_EQ(judged(200e6, 1'000'000'000'000, 0).verdict, Verdict::Pass);
  const Finding close = judged(120e6, 1'000'000'000'000, 100e6);
  EXPECT_EQ(close.verdict, Verdict::Warn);
  EXPECT_THAT(close.what, HasSubstr("/takes writes 120 MB a second, 1000 GB free; the cameras need 100 MB"));
  EXPECT_THAT(close.what, HasSubstr("a faster disk leaves room"));
  const Finding full = judged(200e6, 30'000'000'000, 100e6);
  EXPECT_EQ(full.verdict, Verdict::Warn);
  EXPECT_THAT(full.what, HasSubstr("full after 5 minutes, make room"));
  EXPECT_EQ(judged(99e6, 1'000'000'000'000, 100e6).verdict, Verdict::Fail);
}

TEST(Check, SaysWhichPortIsTaken) {
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in here = {};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&here), size), 0);
  ASSERT_EQ(::listen(fd, 1), 0);
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&here), &size);
  const Finding taken = look_at_port("127.0.0.1", ntohs(here.sin_port), "the page");
  EXPECT_EQ(taken.verdict, Verdict::Fail);
  EXPECT_THAT(taken.what, HasSubstr("ss -ltnp"));
  ::close(fd);
  EXPECT_EQ(look_at_port("127.0.0.1", ntohs(here.sin_port), "the page").verdict, Verdict::Pass);
  EXPECT_EQ(look_at_port("nowhere", 1, "the page").verdict, Verdict::Warn);
}

TEST(Check, CountsTheFilesThatAProgramMayOpen) {
  rlimit before = {};
  ::getrlimit(RLIMIT_NOFILE, &before);
  rlimit limit = before;
  limit.rlim_cur = 256;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
  const Finding few = look_at_sockets();
  EXPECT_EQ(few.verdict, Verdict::Warn);
  EXPECT_THAT(few.what, HasSubstr("may open 256 files; a studio of many cameras needs more: ulimit -n 4096"));
  limit.rlim_cur = 3;  // standard input, output and errors
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
  const Finding none = look_at_sockets();
  limit.rlim_cur = std::min<rlim_t>(4096, before.rlim_max);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
  EXPECT_EQ(none.verdict, Verdict::Fail);
  EXPECT_THAT(none.what, HasSubstr("none can be opened"));
  EXPECT_EQ(look_at_sockets().verdict, limit.rlim_cur >= 1024 ? Verdict::Pass : Verdict::Warn);
  ::setrlimit(RLIMIT_NOFILE, &before);
}

}  // namespace
}  // namespace floatstage::apps
