#include "studio/node/capture_session.h"

#include <chrono>
#include <thread>

#include "core/log.h"
#include "core/text.h"
#include "studio/node/capture_node.h"
#include "studio/node/service_notice.h"
#include "studio/page/page_access.h"
#include "studio/page/page_server.h"

namespace floatstage::studio {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTurn = std::chrono::milliseconds(50);
constexpr std::chrono::seconds kSealing{10};
constexpr auto kLongestLook = std::chrono::seconds(10);  // at the cameras' agreement, before a take begins

double since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

CaptureReport report_of(const CaptureNode& node) {
  CaptureReport report;
  const NodeStatus status = node.status();
  for (std::size_t i = 0; i < status.cameras.size(); ++i) {
    const NodeCamera& seen = status.cameras[i];
    CapturedCamera camera;
    camera.serial = seen.serial;
    camera.stats = {seen.delivered, seen.lost, seen.corrupt, seen.starved, seen.failed};
    camera.reconnects = seen.reconnects;
    camera.trouble = seen.trouble;
    camera.frame_rate = node.mean_frame_rate(i);
    report.cameras.push_back(std::move(camera));
  }
  report.recording = node.quality();
  report.take = node.take();
  return report;
}

// Until the cameras' agreement is known, or for as long as one waits for that.
void look_before_recording(CaptureNode& node, const std::function<bool()>& stop) {
  const auto begun = Clock::now();
  while (!node.agreement_seen() && !node.over() && !stop() && Clock::now() - begun < kLongestLook) {
    node.poll();
    std::this_thread::sleep_for(kTurn);
  }
}

// However a session ends: no camera offers pictures to somebody who has gone.
struct StopFirst {
  CaptureNode& node;
  ~StopFirst() { (void)node.finish(); }
};

// The node's page, where the config has one.
Result<std::unique_ptr<PageServer>> serve_page(CaptureNode& node) {
  const std::optional<PageSettings>& web = node.config().web;
  if (!web) return std::unique_ptr<PageServer>();
  Result<std::string> token = page_token(web->token_file);
  if (!token) return forward(token);
  Result<std::unique_ptr<PageServer>> page =
      PageServer::serve(node, node.config().cameras.size(), *web, *token);
  if (!page) return page;
  node.add_tap([server = page->get()](const Frame& frame) { server->offer(frame); });
  log::info(text("the node's page: ", (*page)->url()));
  return page;
}

}  // namespace

Result<CaptureReport> run_capture(const CaptureConfig& config, const CaptureOptions& options,
                                  const std::function<bool()>& stop,
                                  const std::function<void(const CaptureReport&)>& progress) {
  Result<std::unique_ptr<CaptureNode>> opened = CaptureNode::open(config, stop);
  if (!opened && opened.error().code == ErrorCode::Cancelled && !options.record) return CaptureReport();
  if (!opened) return forward(opened);
  CaptureNode& node = **opened;
  ServiceNotice notice;
  const Result<std::unique_ptr<PageServer>> page = serve_page(node);
  if (!page) return forward(page);
  std::shared_ptr<void> companion;
  if (options.companion) {
    Result<std::shared_ptr<void>> come = options.companion(node);
    if (!come) return forward(come);
    companion = std::move(*come);
  }
  const StopFirst stop_first{node};
  // Recordings are copied from their first picture on; of cameras that stream one knows more after a moment.
  const bool at_once = options.record && node.plays_recordings();
  const auto record = [&] { return node.record_into(options.take, ""); };
  if (at_once)
    if (Result<std::string> begun = record(); !begun) return forward(begun);
  node.begin();
  if (options.record && !at_once) {
    look_before_recording(node, stop);
    if (Result<std::string> begun = record(); !begun) return forward(begun);
  }
  notice.ready(text(config.cameras.size(), " cameras"));
  const auto begun = Clock::now();
  auto told = begun;
  while (!node.over() && !stop()) {
    node.poll();
    if (node.alive()) notice.alive();
    if (options.seconds > 0 && since(begun) >= options.seconds) break;
    if (options.record && options.seconds > 0 && !node.recording()) break;  // it has failed
    if (since(told) >= 1) {
      told = Clock::now();
      progress(report_of(node));
    }
    std::this_thread::sleep_for(kTurn);
  }
  notice.stopping();
  Result<void> finished = node.finish();
  if (!finished) return forward(finished);
  // Ctrl-C is how a recording ends, and it is sealed all the same unless that takes long.
  const auto asked_long_ago = Clock::now() + kSealing;
  (void)node.wait_for_seals([&] { return stop() && Clock::now() > asked_long_ago; });
  if (const std::string why = node.status().last_recording; options.record && !why.empty())
    return fail(ErrorCode::Io, why);
  return report_of(node);
}

}  // namespace floatstage::studio
