#include "studio/live/live_remote.h"

#include "core/rig_io.h"

namespace floatstage::studio {

Result<LiveRemote> open_live_remote(const LiveRemoteOptions& options) {
  const Result<Rig> rig = load_rig(options.rig);
  if (!rig) return forward(rig);
  RemoteOptions from;
  from.recon = options.recon;
  from.nodes = options.nodes;
  if (!options.keys.empty()) {
    Result<wire::StudioKeys> keys = wire::load_keys(options.keys);
    if (!keys) return forward(keys);
    from.keys = std::move(*keys);
  }
  LiveRemote remote;
  for (const std::string& address : options.control) {
    Result<std::unique_ptr<wire::ControlClient>> node = wire::ControlClient::connect(address, from.keys);
    if (!node) return forward(node);
    remote.control.push_back(std::move(*node));
  }
  Result<std::unique_ptr<RemoteScenes>> scenes = RemoteScenes::open(*rig, from);
  if (!scenes) return forward(scenes);
  remote.scenes = std::move(*scenes);
  return remote;
}

nlohmann::ordered_json to_json(const RemoteScenes::NetworkCounters& c, double seconds) {
  const auto each_second = [&](std::uint64_t n) {
    return seconds > 0 ? static_cast<double>(n) / seconds : 0.0;
  };
  return {{"bytes_per_second", each_second(c.network.bytes)},
          {"scenes", c.network.scenes},
          {"scene_bytes_per_second", each_second(c.network.scene_bytes)},
          {"tiles", c.network.tiles},
          {"tile_bytes_per_second", each_second(c.network.tile_bytes)},
          {"scenes_incomplete", c.joined.incomplete},
          {"scenes_of_another_rig", c.other_rig},
          {"missed", c.network.missed},
          {"malformed", c.network.malformed},
          {"other_version", c.network.other_version},
          {"refused", c.network.refused},
          {"dropped", c.network.dropped}};
}

}  // namespace floatstage::studio
