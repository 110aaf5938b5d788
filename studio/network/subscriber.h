#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "core/result.h"
#include "core/time.h"
#include "studio/messages/camera_view.h"
#include "studio/messages/message.h"
#include "studio/messages/studio_control.h"
#include "studio/messages/studio_scene.h"
#include "studio/network/keys.h"

namespace floatstage::studio::wire {

struct SubscriberOptions {
  std::vector<std::string> addresses = {};  ///< of publishers: one or more
  std::optional<StudioKeys> keys = {};
  std::vector<MessageKind> kinds = {};  ///< all messages of these; tiles are asked for with want_tiles()
  int queue = 64;                       ///< messages that wait for next(); a full queue drops the oldest
};

struct SubscriberCounters {
  std::uint64_t messages = 0, bytes = 0;  ///< that arrived, of any kind
  std::uint64_t outlines = 0, tiles = 0, scenes = 0, statuses = 0;
  std::uint64_t outline_bytes = 0, tile_bytes = 0, scene_bytes = 0;
  std::uint64_t malformed = 0;      ///< messages that make no sense
  std::uint64_t other_version = 0;  ///< messages of another release
  std::uint64_t missed = 0;         ///< messages that were sent and did not arrive: jumps in their numbers
  std::uint64_t dropped = 0;        ///< by the full queue, oldest first
  std::uint64_t refused = 0;  ///< handshakes that failed: wrong keys, another release, or no ZeroMQ there
};

/// What arrives. A CameraView is of an outline (without a tile) or of a tile (with an empty outline).
using Received =
    std::variant<std::shared_ptr<const CameraView>, std::shared_ptr<const StudioScene>, NodeStatus>;

/// One end that listens, to one or more publishers. A thread of its own reads and decodes into a bounded
/// queue (policy DropOldest, counted). It tells its publishers what it wants twice a second, and at once when
/// that changes or one of them comes: those that are not there yet, go away and come back are connected to as
/// soon as they are there. What makes no sense is counted, and a warning says so at most once a second.
class Subscriber {
 public:
  /// Errors: those of check_address(); InvalidArgument for kinds that nobody is told.
  static Result<std::unique_ptr<Subscriber>> connect(const SubscriberOptions& options);
  ~Subscriber();

  /// From now on the tiles of these cameras, and of no others; of the first kMostWatched where there are
  /// more. From any thread.
  void want_tiles(std::set<std::string> serials);

  /// The next message, or nothing within `timeout`. From any thread.
  std::optional<Received> next(Nanoseconds timeout);

  SubscriberCounters counters() const;

 private:
  struct Impl;
  explicit Subscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::studio::wire
