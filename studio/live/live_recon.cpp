#include "studio/live/live_recon.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "core/log.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage::studio {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

Result<LiveReconReport> run_live_recon(const LiveReconOptions& options, const std::function<bool()>& stop) {
  const Result<Rig> rig = load_rig(options.rig);
  if (!rig) return forward(rig);
  ReconOptions recon;
  recon.nodes = options.nodes;
  recon.publisher.address = options.address;
  recon.gather.longest_wait = Nanoseconds{std::llround(1e6 * options.longest_wait_ms)};
  if (!options.keys.empty()) {
    Result<wire::StudioKeys> keys = wire::load_keys(options.keys);
    if (!keys) return forward(keys);
    recon.publisher.keys = std::move(*keys);
  }
  const Result<std::unique_ptr<ReconService>> service = ReconService::open(*rig, recon);
  if (!service) return forward(service);
  log::info(text("scenes at ", (*service)->address()));
  const auto begun = Clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
  while (!stop() && (options.seconds <= 0 || passed() < options.seconds))
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return LiveReconReport{(*service)->counters(), passed()};
}

nlohmann::ordered_json to_json(const LiveReconReport& report) {
  const ReconCounters& c = report.counters;
  const double seconds = report.seconds;
  const auto each_second = [&](std::uint64_t n) {
    return seconds > 0 ? static_cast<double>(n) / seconds : 0.0;
  };
  return {{"seconds", seconds},
          {"scenes", c.scenes},
          {"fps", each_second(c.scenes)},
          {"hull_ms", {{"p50", c.hull_ms.percentile(0.5)}, {"p99", c.hull_ms.percentile(0.99)}}},
          {"from_nodes",
           {{"outlines", c.from_nodes.outlines},
            {"bytes_per_second", each_second(c.from_nodes.bytes)},
            {"missed", c.from_nodes.missed},
            {"malformed", c.from_nodes.malformed},
            {"other_version", c.from_nodes.other_version},
            {"refused", c.from_nodes.refused}}},
          {"to_viewers",
           {{"scenes", c.to_viewers.scenes},
            {"bytes_per_second", each_second(c.to_viewers.scene_bytes)},
            {"left_out", c.to_viewers.left_out},
            {"malformed", c.to_viewers.malformed + c.to_viewers.other_version},
            {"turned_away", c.to_viewers.turned_away},
            {"refused", c.to_viewers.refused}}},
          {"dropped",
           {{"instants_overtaken", c.gathered.overtaken},
            {"instants_incomplete", c.gathered.incomplete},
            {"instants_failed", c.failed},
            {"views_late", c.gathered.late},
            {"views_off_clock", c.gathered.off_clock},
            {"views_of_unknown_cameras", c.gathered.unknown_cameras},
            {"messages", c.from_nodes.dropped}}}};
}

}  // namespace floatstage::studio
