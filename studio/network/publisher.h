#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "studio/messages/camera_view.h"
#include "studio/messages/studio_control.h"
#include "studio/messages/studio_scene.h"
#include "studio/messages/view_message.h"
#include "studio/network/keys.h"

namespace floatstage::studio::wire {

struct PublisherOptions {
  std::string address = "tcp://127.0.0.1:5570";  ///< port 0: any that is free
  std::optional<StudioKeys> keys = {};           ///< needed for addresses that other machines reach
  TileOptions tiles = {};
  int queue = 32;     ///< messages that wait to be encoded; a full queue drops the oldest
  int per_peer = 64;  ///< messages that wait for one subscriber; more are not sent to it
};

struct PublisherCounters {
  std::uint64_t outlines = 0, tiles = 0, scenes = 0, statuses = 0;  ///< encoded and handed to the network
  std::uint64_t outline_bytes = 0, tile_bytes = 0, scene_bytes = 0, status_bytes = 0;
  std::map<std::string, std::uint64_t> tiles_by_camera;  ///< of the tiles, each camera's share
  std::uint64_t dropped = 0;                             ///< by the full queue, oldest first
  std::uint64_t unsendable = 0;                          ///< views that cannot be a message
  std::uint64_t left_out = 0;       ///< messages that a peer missed because it read too slowly, for each peer
  std::uint64_t refused = 0;        ///< handshakes that failed: wrong keys, another release, or no ZeroMQ
  std::uint64_t malformed = 0;      ///< messages of peers that are no watch
  std::uint64_t other_version = 0;  ///< messages of peers that are of another release
  std::uint64_t turned_away = 0;    ///< watches of more peers than are served
};

/// One end that tells: a camera node's views, or reconstruction's scenes. What it is given goes through a
/// bounded queue (policy DropOldest, counted) to a thread of its own, which encodes and sends; nothing here
/// ever waits for the network. A subscriber that does not read fills its own buffers, then misses messages,
/// and harms nobody else.
///
/// What a subscriber watches it says again and again (Watch, Audience): a bounded set of its own. A tile is
/// encoded only while somebody watches its camera, and nothing is sent to who did not ask for it.
class Publisher {
 public:
  /// Errors: those of check_address(), and Io where the port is taken.
  static Result<std::unique_ptr<Publisher>> bind(const PublisherOptions& options);
  ~Publisher();

  /// From any thread.
  void publish(std::shared_ptr<const CameraView> view);
  void publish(std::shared_ptr<const StudioScene> scene);
  void publish(NodeStatus status);

  /// Somebody wants this camera's texture: without it, its tile need not be made.
  bool wants_tile(const std::string& serial) const;

  const std::string& address() const;
  PublisherCounters counters() const;

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::studio::wire
