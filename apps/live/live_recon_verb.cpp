#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/live/live_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/verb.h"
#include "pipeline/json_report.h"
#include "studio/live/live_recon.h"

namespace floatstage::apps {
namespace {

struct LiveReconArguments {
  studio::LiveReconOptions recon;
  std::filesystem::path json;
};

Result<void> run_live_recon(const LiveReconArguments& o) {
  const Result<studio::LiveReconReport> report = studio::run_live_recon(o.recon, interrupted);
  if (!report) return forward(report);
  const studio::ReconCounters& counters = report->counters;
  std::printf("%.1f scenes a second over %.0f s, hull p50 %.0f ms; %.1f kB a second came, %.1f kB went\n",
              static_cast<double>(counters.scenes) / report->seconds, report->seconds,
              counters.hull_ms.percentile(0.5),
              1e-3 * static_cast<double>(counters.from_nodes.bytes) / report->seconds,
              1e-3 * static_cast<double>(counters.to_viewers.scene_bytes) / report->seconds);
  if (o.json.empty()) return {};
  return pipeline::save_json(to_json(*report), o.json);
}

}  // namespace

void add_live_recon(CLI::App& live, Chosen& chosen) {
  auto options = std::make_shared<LiveReconArguments>();
  studio::LiveReconOptions& recon = options->recon;
  CLI::App* verb = add_verb(
      live, chosen, "recon", "The machine of a studio that makes surfaces of what capture nodes see; no view",
      {"floatstage live recon tcp://192.168.7.20:5580 --nodes tcp://192.168.7.11:5570 --rig rig.json",
       "floatstage live recon tcp://*:5580 --nodes tcp://left:5570,tcp://right:5570 --rig rig.json --keys "
       "studio.keys"});
  verb->add_option("address", recon.address, "Where viewers get the scenes, tcp://…")->required();
  add_list(*verb, "--nodes", recon.nodes, "Addresses of the capture nodes")->required();
  verb->add_option("--rig", recon.rig, "The studio's rig.json")->required()->type_name("FILE");
  verb->add_option("--keys", recon.keys, "The studio's keys, see `floatstage keys`")->type_name("FILE");
  add_seconds(*verb, recon.seconds, "How long (default: until Ctrl-C)");
  add_json(*verb, options->json);
  verb->add_option("--longest-wait", recon.longest_wait_ms, "ms that an instant waits for late cameras")
      ->capture_default_str()
      ->type_name("MS")
      ->check(CLI::NonNegativeNumber)
      ->group(kGroupTuning);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_live_recon(*options); }; });
}

}  // namespace floatstage::apps
