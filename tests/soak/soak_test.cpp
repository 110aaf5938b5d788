// A studio at work for a while: eight GigE cameras of which two lose packets, a take being recorded, the page
// open, a reconstruction and a live view attached. Ten minutes: `./run soak`.

#include <atomic>
#include <cstdlib>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/take.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/soak/gige_stage.h"
#include "tests/soak/process_samples.h"
#include "tests/support/eventually.h"
#include "tests/support/http_client.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/network_lab.h"
#include "tests/support/own_network.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr int kCameras = 8, kPoses = 5, kPort = 8470;
constexpr double kRate = 10, kLostPackets = 0.002;  // ten pictures of a short run
constexpr const char* kToken = "0123456789abcdef0123";
constexpr const char* kNode = "tcp://127.0.0.1:5570";
constexpr const char* kRecon = "tcp://127.0.0.1:5580";

int wanted_seconds() {
  if (const char* wanted = std::getenv("FLOATSTAGE_SOAK_SECONDS")) return std::atoi(wanted);
  return wants_long_tests() ? 600 : 20;
}

// What a browser does with the page: reads status and previews as they come, and asks for the page itself.
class OpenPage {
 public:
  OpenPage() {
    thread_ = std::thread([this] {
      const std::vector<std::string> me = {text("Authorization: Bearer ", kToken)};
      WebSocketClient page(kPort, "/live", me);
      open_ = page.status() == 101;
      while (!closing_ && open_) {
        open_ = page.next().kind != 0;
        if (++messages_ % 100 == 0) asked_ += http_request(kPort, "GET", "/api/status", me).status == 200;
      }
    });
  }
  ~OpenPage() { close(); }
  // While the node still sends.
  void close() {
    closing_ = true;
    if (thread_.joinable()) thread_.join();
  }
  bool open() const { return open_; }
  int messages() const { return messages_; }
  int answered() const { return asked_; }

 private:
  std::atomic<bool> open_{false}, closing_{false};
  std::atomic<int> messages_{0}, asked_{0};
  std::thread thread_;
};

class Soak : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(enter_own_network());
    std::vector<double> lost(kCameras, 0);
    for (int i = 1; i < kCameras; ++i) ASSERT_TRUE(add_loopback_address(i + 1));
    lost[2] = lost[5] = kLostPackets;
    SyntheticRigOptions rig;
    rig.cameras = kCameras;
    rig.width = 160;
    rig.height = 120;
    stage_ = std::make_unique<GigeStage>(rig, kRate, kPoses, lost);
    ASSERT_THAT(save_rig(stage_->rig(), folder_ / "rig.json"), IsOk());
    folder_.write("page.token", text(kToken, "\n"));
    std::filesystem::permissions(folder_ / "page.token", std::filesystem::perms::owner_read);
    folder_.write("node.toml", text("[studio]\nframe_rate = ", kRate, "\nrig = 'rig.json'\nname = 'soak'\n",
                                    "[recording]\nfolder = 'takes'\npreroll_seconds = 0\n[web]\nport = ",
                                    kPort, "\ntoken_file = 'page.token'\n[publish]\naddress = '", kNode,
                                    "'\ncontrol = 'tcp://127.0.0.1:5571'\n", stage_->toml()));
  }

  RunningProgram& run(const std::string& name, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), FLOATSTAGE_PROGRAM);
    arguments.insert(arguments.end(), {"--json", (folder_ / (name + ".json")).string()});
    programs_.push_back(std::make_unique<RunningProgram>(arguments, (folder_ / (name + ".log")).string()));
    samples_.emplace_back(name, programs_.back()->pid());
    return *programs_.back();
  }
  RunningProgram& start_node() {
    return run("node",
               {"capture", "--config", (folder_ / "node.toml").string(), "--record", "-o", take().string()});
  }
  RunningProgram& start_recon() {
    return run("recon",
               {"live", "recon", kRecon, "--nodes", kNode, "--rig", (folder_ / "rig.json").string()});
  }
  RunningProgram& start_view() {
    return run("view", {"live", "view", kRecon, "--nodes", kNode, "--rig", (folder_ / "rig.json").string(),
                        "--headless", "--size", "160x120", "--quality", "5", "--target-fps", "0"});
  }
  // Ends a program as a service manager does; what it reports.
  Json end(RunningProgram& program, const std::string& name) {
    program.terminate();
    EXPECT_EQ(program.wait(), 0) << program.output();
    const Result<std::string> bytes = read_file(folder_ / (name + ".json"));
    return bytes ? Json::parse(*bytes, nullptr, false) : Json();
  }
  std::filesystem::path take() const { return folder_ / "take"; }

  void expect_every_instant_accounted_for(const Json& report);
  void expect_nothing_grows(bool whole);

  TempFolder folder_;
  std::unique_ptr<GigeStage> stage_;
  std::vector<std::unique_ptr<RunningProgram>> programs_;
  std::vector<ProcessSamples> samples_;
};

// Of each camera every instant from the take's first to its last has a picture, or a gap that a counter
// names.
void Soak::expect_every_instant_accounted_for(const Json& report) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(this->take());
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete);
  const std::size_t instants = (*take)->rows(0).size();
  for (int i = 0; i < kCameras; ++i) {
    const Json& camera = report["cameras"][static_cast<std::size_t>(i)];
    const std::string serial = camera["serial"];
    const std::vector<FrameRow>& rows = (*take)->rows(i);
    std::size_t pictures = 0;
    for (const FrameRow& row : rows) {
      pictures += row.media_index.has_value();
      EXPECT_TRUE(row.media_index || row.info.status == FrameStatus::Lost) << serial;
    }
    const std::size_t gaps = rows.size() - pictures;
    EXPECT_EQ(rows.size(), instants) << serial;
    EXPECT_EQ(pictures, camera["delivered"]) << serial;
    EXPECT_EQ(gaps, camera["gaps"]) << serial;
    EXPECT_EQ(gaps, camera["lost"].get<std::size_t>() + camera["unexposed"].get<std::size_t>()) << serial;
    EXPECT_EQ(camera["reconnects"], 0) << serial;
    if (i == 2 || i == 5) {
      EXPECT_GT(camera["failed"], 0) << serial << " sends with losses";
    }
    std::printf(
        "  %s: %zu instants, %zu pictures, %zu gaps: %d lost (%d arrived in part), %d not exposed; %d "
        "twice\n",
        serial.c_str(), rows.size(), pictures, gaps, camera["lost"].get<int>(), camera["failed"].get<int>(),
        camera["unexposed"].get<int>(), camera["duplicates"].get<int>());
  }
  const auto [code, said] = run_command(text(FLOATSTAGE_PROGRAM, " take verify ", this->take().string()));
  EXPECT_EQ(code, 0) << said;
}

// From a fifth of the time (minute 2 of 10) to its end. A short run looks from its middle on, and is still
// growing into its buffers then.
void Soak::expect_nothing_grows(bool whole) {
  const double slack_mb = whole ? 0 : 20, from = whole ? 0.15 : 0.4, to = whole ? 0.2 : 0.5;
  for (const ProcessSamples& s : samples_) {
    const double before = s.resident_mb(from, to), after = s.resident_mb(0.95, 1);
    std::printf("  %s: %.1f MB at first, %.1f MB at the end; files %.0f and %.0f; threads %.0f and %.0f\n",
                s.name().c_str(), before, after, s.files(from, to), s.files(0.95, 1), s.threads(from, to),
                s.threads(0.95, 1));
    EXPECT_LE(after, 1.05 * before + slack_mb) << s.name();
    EXPECT_EQ(s.files(0.95, 1), s.files(from, to)) << s.name();
    EXPECT_EQ(s.threads(0.95, 1), s.threads(from, to)) << s.name();
  }
}

TEST_F(Soak, LosesNothingSilentlyAndGrowsNowhere) {
  const int seconds = wanted_seconds();
  RunningProgram& node = start_node();
  RunningProgram& recon = start_recon();
  ASSERT_TRUE(eventually([&] { return node.output().find("the node's page:") != std::string::npos; }))
      << node.output();
  RunningProgram& view = start_view();
  OpenPage page;
  ASSERT_TRUE(eventually([&] { return view.output().find("live quality") != std::string::npos; }))
      << view.output();
  const auto begun = Clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  while (passed() < seconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(seconds > 100 ? 1000 : 200));
    for (ProcessSamples& s : samples_) s.look(passed());
    ASSERT_TRUE(node.running() && recon.running() && view.running())
        << node.output() << recon.output() << view.output();
  }
  EXPECT_TRUE(page.open()) << "to the end";
  page.close();
  const Json shown = end(view, "view"), made = end(recon, "recon"), told = end(node, "node");
  std::printf("%d s; page: %d messages, %d answers\n", seconds, page.messages(), page.answered());
  EXPECT_GT(page.messages(), seconds * kCameras);
  EXPECT_GT(page.answered(), page.messages() / 100 - 2);
  expect_every_instant_accounted_for(told);
  expect_nothing_grows(seconds >= 600);

  // Each outline that was told was read, or its number is missed; but those before the first was asked for.
  const Json &from = made["from_nodes"], &out = told["published"];
  const auto sent = out["outlines"]["sent"].get<std::int64_t>();
  const auto read = from["outlines"].get<std::int64_t>() + from["missed"].get<std::int64_t>();
  EXPECT_LE(read, sent);
  EXPECT_GE(read, sent - static_cast<std::int64_t>(4 * kRate * kCameras)) << "beginning and end";
  EXPECT_EQ(from["malformed"], 0);
  EXPECT_EQ(shown["network"]["malformed"], 0);
  const Json& latency = shown["latency_ms"];
  std::printf("  outlines: %d told, %d read, %d missed, %d left out\n", out["outlines"]["sent"].get<int>(),
              from["outlines"].get<int>(), from["missed"].get<int>(), out["left_out"].get<int>());
  std::printf("  %.1f scenes a second; from exposure to picture p50 %.0f ms, p99 %.0f ms, most %.0f ms\n",
              shown["fps"].get<double>(), latency["p50"].get<double>(), latency["p99"].get<double>(),
              latency["max"].get<double>());
  EXPECT_GT(shown["fps"], 0.5) << node.output() << recon.output() << view.output();
  EXPECT_GT(latency["p50"], 0);
}

}  // namespace
}  // namespace floatstage
