#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/result.h"
#include "studio/live/remote_scenes.h"
#include "studio/network/control_client.h"

namespace floatstage::studio {

/// Of `live view`: the machine of the studio that shows.
struct LiveRemoteOptions {
  std::string recon;                 ///< address of the machine that reconstructs
  std::vector<std::string> nodes;    ///< addresses of the capture nodes
  std::vector<std::string> control;  ///< where they answer requests; may be empty
  std::filesystem::path rig, keys;
};

/// What a view of other machines needs.
struct LiveRemote {
  std::unique_ptr<RemoteScenes> scenes;
  std::vector<std::unique_ptr<wire::ControlClient>> control;  ///< of each node
};

/// Errors: the rig, the keys, the addresses.
Result<LiveRemote> open_live_remote(const LiveRemoteOptions& options);

/// What came over the network, for machines.
nlohmann::ordered_json to_json(const RemoteScenes::NetworkCounters& counters, double seconds);

}  // namespace floatstage::studio
