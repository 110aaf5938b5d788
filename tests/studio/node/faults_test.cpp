// What may go wrong in a studio, each once: the rest goes on, recovers by itself, and no frame is lost
// without a row that says so.
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "capture/take.h"
#include "core/file.h"
#include "studio/node/capture_node.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/studio/node/studios.h"
#include "tests/support/http_client.h"
#include "tests/support/matchers.h"
#include "tests/support/network_lab.h"
#include "tests/support/own_network.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;

bool poll_until(CaptureNode& node, const std::function<bool()>& so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(90);
  while (!so() && std::chrono::steady_clock::now() < end) {
    node.poll();
    ::poll(nullptr, 0, 20);
  }
  return so();
}

/// Fake GigE cameras in a network of their own, being recorded.
class AStudioOfGigeCameras : public testing::Test {
 protected:
  void begin(int cameras) {
    ASSERT_TRUE(enter_own_network());
    CaptureConfig config;
    config.frame_rate = 20;
    config.folder = folder_.path();
    config.keep_free_bytes = 0;
    config.recorder.take.frame_rate = 20;
    config.recorder.take.label = "take";
    config.recorder.take.codec = capture::TakeCodec::Raw;
    for (int n = 1; n <= cameras; ++n) {
      ASSERT_TRUE(n == 1 || add_loopback_address(n));
      const std::string serial = "FAKE" + std::to_string(n);
      devices_.push_back(std::make_unique<capture::FakeGigeCamera>(n, serial));
      config.cameras.push_back(
          {serial, devices_.back()->uri("format=gray8&width=64&height=48&rate=20&resend=off")});
    }
    auto node = CaptureNode::open(config);
    ASSERT_THAT(node, IsOk());
    node_ = std::move(*node);
    node_->begin();
    ASSERT_TRUE(poll_until(*node_, [&] { return node_->agreement_seen(); }));
    const Result<std::string> name = node_->start_recording("");
    ASSERT_THAT(name, IsOk());
    take_ = folder_ / *name;
  }
  std::uint64_t delivered(std::size_t camera) { return node_->status().cameras[camera].delivered; }
  std::string trouble(std::size_t camera) { return node_->status().cameras[camera].trouble; }
  bool comes_more_of(std::size_t camera, std::uint64_t frames) {
    const std::uint64_t seen = delivered(camera);
    return poll_until(*node_, [&] { return delivered(camera) >= seen + frames; });
  }
  /// Stops, and checks what every take keeps to: as many rows for each camera, each row's picture or gap
  /// accounted for, rows of all cameras at the same instants.
  std::vector<std::size_t> finished_gaps() {
    EXPECT_THAT(node_->stop_recording(), IsOk());
    const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(take_);
    EXPECT_THAT(take, IsOk());
    std::vector<std::size_t> gaps;
    const capture::RecordingQuality quality = *node_->quality();
    for (int i = 0; i < static_cast<int>(quality.cameras.size()); ++i) {
      const auto& rows = (*take)->rows(i);
      EXPECT_EQ(rows.size(), (*take)->rows(0).size());
      std::size_t missing = 0;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        missing += rows[k].media_index ? 0 : 1;
        EXPECT_NEAR(seconds(rows[k].info.exposure_start - (*take)->rows(0)[k].info.exposure_start), 0, 0.03)
            << "camera " << i << " row " << k;
      }
      EXPECT_EQ(missing, quality.cameras[static_cast<std::size_t>(i)].skips);
      gaps.push_back(missing);
    }
    return gaps;
  }

  TempFolder folder_;
  std::vector<std::unique_ptr<capture::FakeGigeCamera>> devices_;
  std::unique_ptr<CaptureNode> node_;
  std::filesystem::path take_;
};

TEST_F(AStudioOfGigeCameras, GoesOnWhileACameraIsFrozenAndTakesItBack) {
  begin(3);
  ASSERT_TRUE(comes_more_of(2, 20));
  devices_[1]->freeze();
  ASSERT_TRUE(poll_until(*node_, [&] { return !trouble(1).empty(); }));
  ASSERT_TRUE(comes_more_of(0, 20)) << "the others go on";
  devices_[1]->thaw();
  ASSERT_TRUE(poll_until(*node_, [&] { return trouble(1).empty(); })) << "it comes back by itself";
  ASSERT_TRUE(comes_more_of(1, 20));
  const std::vector<std::size_t> gaps = finished_gaps();
  EXPECT_GE(gaps[1], 20u);
  EXPECT_LT(gaps[0], gaps[1]);
}

TEST_F(AStudioOfGigeCameras, RecoversFromALinkThatWasCutForFiveSeconds) {
  begin(2);
  ASSERT_TRUE(comes_more_of(1, 20));
  ASSERT_TRUE(set_loopback(false));
  const auto cut = std::chrono::steady_clock::now();
  ASSERT_TRUE(poll_until(*node_, [&] {
    return std::chrono::steady_clock::now() - cut > std::chrono::seconds(5) && !trouble(0).empty() &&
           !trouble(1).empty();
  }));
  ASSERT_TRUE(set_loopback(true));
  ASSERT_TRUE(poll_until(*node_, [&] { return trouble(0).empty() && trouble(1).empty(); }));
  ASSERT_TRUE(comes_more_of(0, 20));
  ASSERT_TRUE(comes_more_of(1, 20));
  const std::vector<std::size_t> gaps = finished_gaps();
  EXPECT_GE(gaps[0], 80u) << "five seconds at 20 a second, less a little jitter of the clocks";
  EXPECT_GE(gaps[1], 80u);
}

TEST(CaptureFaults, AFullDiskEndsTheTakeAndNotTheStudio) {
  const TempFolder folder;
  if (::unshare(CLONE_NEWNS) != 0 || ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=3m") != 0)
    GTEST_SKIP() << "mounting a small disk takes more rights than this test has";
  auto node =
      CaptureNode::open(live_studio(2, 50, folder.path()));  // keeps nothing free: it runs into the wall
  ASSERT_THAT(node, IsOk());
  (*node)->begin();
  ASSERT_TRUE(poll_until(**node, [&] { return (*node)->agreement_seen(); }));
  const Result<std::string> first = (*node)->start_recording("full");
  ASSERT_THAT(first, IsOk());
  ASSERT_TRUE(poll_until(**node, [&] { return !(*node)->recording(); }));
  EXPECT_THAT((*node)->status().last_recording, HasSubstr("could not be written further"));
  {
    const Result<std::unique_ptr<capture::TakeReader>> cut = capture::TakeReader::open(folder / *first);
    ASSERT_THAT(cut, IsOk());
    EXPECT_FALSE((*cut)->manifest().complete);
    for (int camera = 0; camera < 2; ++camera) {
      ASSERT_GT((*cut)->rows(camera).size(), 20u) << "what was written is there";
      EXPECT_TRUE((*cut)->frame(camera, 10).has_value());
    }
  }  // a file that is open keeps its room
  // Room is made, and the next take is as good as any.
  std::filesystem::remove_all(folder / *first);
  const Result<std::string> second = (*node)->start_recording("again");
  ASSERT_THAT(second, IsOk());
  ASSERT_TRUE(poll_until(**node, [&] { return (*node)->quality()->cameras[0].recorded > 10; }));
  EXPECT_THAT((*node)->stop_recording(), IsOk());
  EXPECT_TRUE((*capture::TakeReader::open(folder / *second))->manifest().complete);
  node->reset();
  ::umount(folder.path().c_str());
}

TEST(CaptureFaults, AClockThatIsTwentyMillisecondsOffIsNamedAndItsFramesKeepTheirRows) {
  const TempFolder folder;
  auto node = CaptureNode::open(live_studio(3, 20, folder.path(), "&late-ms=20"));
  ASSERT_THAT(node, IsOk());
  (*node)->begin();
  ASSERT_TRUE(poll_until(**node, [&] { return !(*node)->status().complaints.empty(); }));
  EXPECT_THAT((*node)->status().complaints, testing::Contains(HasSubstr("camera 'CAM1'")));
  const Result<std::string> name = (*node)->start_recording("");
  ASSERT_THAT(name, IsOk());
  ASSERT_TRUE(poll_until(**node, [&] { return (*node)->quality()->cameras[0].recorded > 40; }));
  ASSERT_THAT((*node)->stop_recording(), IsOk());
  const capture::RecordingQuality quality = *(*node)->quality();
  EXPECT_FALSE(quality.pass());
  EXPECT_THAT(quality.complaints, testing::Contains(HasSubstr("up to 20 ms apart")));
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / *name);
  ASSERT_THAT(take, IsOk());
  for (std::size_t row = 0; row < (*take)->rows(0).size(); ++row) {
    const FrameRow &late = (*take)->rows(0)[row], &good = (*take)->rows(1)[row];
    if (!late.media_index || !good.media_index) continue;
    EXPECT_EQ((late.info.exposure_start - good.info.exposure_start).count, 20'000'000);
  }
}

/// The daemon as a process of its own, as systemd would start it.
class ADaemon : public testing::Test {
 protected:
  void start(const std::string& take = "take", const std::string& more = "") {
    std::filesystem::permissions(folder_.write("token", "token-of-a-file-123\n"),
                                 std::filesystem::perms::owner_read);
    const std::filesystem::path config = folder_.write("studio.toml", text(R"(
[studio]
frame_rate = 25
[recording]
folder = "takes"
codec = "raw"
keep_free_mb = 0
[[camera]]
serial = "A"
source = "synthetic:live=on&loop=2&width=64&height=48&samples=1&rate=25&cameras=2&camera=0"
[[camera]]
serial = "B"
source = "synthetic:live=on&loop=2&width=64&height=48&samples=1&rate=25&cameras=2&camera=1"
)",
                                                                           more));
    if (notices_ >= 0) ::close(notices_);
    notices_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = folder_ / "notices";
    std::filesystem::remove(path);
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(notices_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    daemon_ = ::fork();
    if (daemon_ == 0) {
      ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
      ::setenv("WATCHDOG_USEC", "300000", 1);
      ::dup2(::open((folder_ / "said.txt").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDERR_FILENO);
      ::execl(FLOATSTAGE_PROGRAM, FLOATSTAGE_PROGRAM, "capture", "--config", config.c_str(), "--record",
              "--out", (folder_ / take).c_str(), "--json", (folder_ / "report.json").c_str(), nullptr);
      ::_exit(127);
    }
  }
  void TearDown() override {
    if (daemon_ > 0) {
      ::kill(daemon_, SIGKILL);
      ::waitpid(daemon_, nullptr, 0);
    }
    ::close(notices_);
  }
  /// Reads what the daemon tells its service manager until that.
  bool tells(const std::string& what) {
    char buffer[1024];
    for (;;) {
      pollfd wait = {notices_, POLLIN, 0};
      if (::poll(&wait, 1, 60'000) != 1) return false;
      const ssize_t bytes = ::recv(notices_, buffer, sizeof buffer, 0);
      if (bytes > 0 && std::string(buffer, static_cast<std::size_t>(bytes)).find(what) != std::string::npos)
        return true;
    }
  }
  bool has_rows(std::size_t wanted, const std::string& take = "take") {
    for (int tries = 0; tries < 3000; ++tries, ::poll(nullptr, 0, 20)) {
      const Result<std::string> rows = read_file(folder_ / take / "B.frames.csv");
      if (rows && static_cast<std::size_t>(std::count(rows->begin(), rows->end(), '\n')) > wanted)
        return true;
    }
    return false;
  }
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(daemon_, -1), &status, 0);
    return status;
  }

  TempFolder folder_;
  pid_t daemon_ = -1;
  int notices_ = -1;
};

TEST_F(ADaemon, ServesItsPageAndMetrics) {
  start("take", "[web]\nport = 0\ntoken_file = \"token\"\n");
  ASSERT_TRUE(tells("READY=1"));
  const std::string said = *read_file(folder_ / "said.txt");
  const std::size_t at = said.find("http://127.0.0.1:");
  ASSERT_NE(at, std::string::npos) << said;
  const int port = std::atoi(said.c_str() + at + 17);
  EXPECT_EQ(http_request(port, "GET", "/metrics").status, 401);
  const HttpAnswer metrics =
      http_request(port, "GET", "/metrics", {"Authorization: Bearer token-of-a-file-123"});
  EXPECT_EQ(metrics.status, 200);
  EXPECT_THAT(metrics.body, HasSubstr("floatstage_camera_frames_total{camera=\"B\",result=\"delivered\"}"));
  ::kill(daemon_, SIGTERM);
  EXPECT_TRUE(tells("STOPPING=1"));
  EXPECT_EQ(WEXITSTATUS(wait()), 0);
}

TEST_F(ADaemon, LosesNothingOnSigterm) {
  start();
  ASSERT_TRUE(tells("READY=1"));
  ASSERT_TRUE(tells("WATCHDOG=1"));
  ASSERT_TRUE(has_rows(30));
  ::kill(daemon_, SIGTERM);
  EXPECT_TRUE(tells("STOPPING=1"));
  const int status = wait();
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder_ / "take");
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete);
  EXPECT_GE((*take)->frame_count(), 30);
  EXPECT_EQ((*take)->rows(0).size(), (*take)->rows(1).size());
  EXPECT_THAT(*read_file(folder_ / "report.json"), HasSubstr("\"verdict\""));
}

TEST(CaptureFaults, AProgramThatIsAskedToEndWhileItsCamerasStartDoesSoWithinASecond) {
  const TempFolder folder;
  // Six pictures of two million pixels take minutes.
  const std::string config = folder
                                 .write("studio.toml",
                                        "[studio]\nframe_rate = 25\n[[camera]]\nserial = 'A'\nsource = "
                                        "'synthetic:live=on&loop=6&width=1600&height=1200&samples=1024'\n")
                                 .string();
  for (const std::vector<std::string>& verb : {std::vector<std::string>{"capture"},
                                               {"capture", "--record", "-o", (folder / "take").string()},
                                               {"check"}}) {
    std::vector<std::string> arguments = {FLOATSTAGE_PROGRAM};
    arguments.insert(arguments.end(), verb.begin(), verb.end());
    arguments.insert(arguments.end(), {"--config", config});
    RunningProgram program(arguments, (folder / "said.txt").string());
    // A busy machine may need seconds to load it; no handler of ours is there before main().
    while (!program.catches(SIGTERM) && program.running())
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::this_thread::sleep_for(std::chrono::seconds(2));
    ASSERT_TRUE(program.running()) << program.output();
    const auto asked = std::chrono::steady_clock::now();
    program.terminate();
    const int code = program.wait();
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count();
    EXPECT_EQ(code, verb.size() == 1 && verb[0] == "capture" ? 0 : 130) << program.output();
    EXPECT_LT(took, 1) << verb[0];
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "take"));
}

TEST_F(ADaemon, ThatIsKilledLeavesATakeThatOpensAndIsStartedAgain) {
  start();
  ASSERT_TRUE(has_rows(30));
  ::kill(daemon_, SIGKILL);
  wait();
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder_ / "take");
  ASSERT_THAT(take, IsOk());
  EXPECT_FALSE((*take)->manifest().complete);
  for (int camera = 0; camera < 2; ++camera) {
    ASSERT_GE((*take)->rows(camera).size(), 28u);
    EXPECT_THAT((*take)->frame(camera, static_cast<int>((*take)->rows(camera).size()) - 1), IsOk());
  }
  // Started again, it records beside what it left.
  start("again");
  ASSERT_TRUE(has_rows(30, "again"));
  ::kill(daemon_, SIGTERM);
  EXPECT_TRUE(tells("STOPPING=1"));
  EXPECT_EQ(WEXITSTATUS(wait()), 0);
  EXPECT_TRUE((*capture::TakeReader::open(folder_ / "again"))->manifest().complete);
  EXPECT_FALSE((*capture::TakeReader::open(folder_ / "take"))->manifest().complete);
}

}  // namespace
}  // namespace floatstage::studio
