#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/result.h"
#include "studio/live/recon_service.h"

namespace floatstage::studio {

/// Of `live recon`: the machine of the studio that reconstructs.
struct LiveReconOptions {
  std::string address;             ///< where viewers get the scenes
  std::vector<std::string> nodes;  ///< addresses of the capture nodes
  std::filesystem::path rig, keys;
  double longest_wait_ms = 60;  ///< of an instant, for views that are late
  double seconds = 0;           ///< 0: until stopped
};

struct LiveReconReport {
  ReconCounters counters;
  double seconds = 0;  ///< that it ran
};

/// Reconstructs on threads of its own until `stop` says so, which is asked twenty times a second, or until
/// the time is over. Errors: the rig, the keys, the addresses.
Result<LiveReconReport> run_live_recon(const LiveReconOptions& options, const std::function<bool()>& stop);

/// How it went, for machines.
nlohmann::ordered_json to_json(const LiveReconReport& report);

}  // namespace floatstage::studio
