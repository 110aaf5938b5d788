#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage {

/// Of `live --recon`: the machine of the studio that reconstructs.
struct LiveReconOptions {
  std::string address;             ///< where viewers get the scenes
  std::vector<std::string> nodes;  ///< addresses of the capture nodes
  std::filesystem::path rig, keys, json;
  double longest_wait_ms = 60;  ///< of an instant, for views that are late
  double seconds = 0;           ///< 0: until stopped
};

/// Reconstructs until it is stopped, then says how it went, for people and, with `json`, for machines.
/// Errors: the rig, the keys, the addresses.
Result<void> run_live_recon(const LiveReconOptions& options);

}  // namespace floatstage
