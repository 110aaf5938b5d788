#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>

#include "core/result.h"
#include "studio/messages/message.h"

namespace floatstage::studio::wire {

/// The most cameras whose tiles one end may ask for by name.
inline constexpr std::size_t kMostWatched = 256;

/// What one end wants to be told from now on, instead of what it wanted before.
struct Watch {
  std::set<MessageKind> kinds;  ///< all messages of these: Outline, Tile, Scene, Status
  std::set<std::string> tiles;  ///< serials of the cameras whose tiles are wanted; at most kMostWatched
  bool operator==(const Watch&) const = default;

  bool covers(MessageKind kind, const std::string& serial) const {
    return kinds.contains(kind) || (kind == MessageKind::Tile && tiles.contains(serial));
  }
};

/// No message of a watch is longer.
inline constexpr std::size_t kLongestWatch = kHeaderBytes + 4 + kMostWatched * (1 + kLongestSerial);

/// InvalidArgument for kinds that nobody is told, for too many cameras, and for serials that cannot travel.
Result<std::string> encode_watch(const Watch& watch);
/// BadData for whatever encode_watch() does not write.
Result<Watch> decode_watch(const Message& message);

}  // namespace floatstage::studio::wire
