#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.h"
#include "core/time.h"

namespace floatstage::studio::wire {

/// What a message carries.
enum class MessageKind : std::uint8_t {
  Outline = 1,  ///< of one camera at one instant: always travels
  Tile =
      2,  ///< the subject's pixels of one camera at one instant: travels when somebody asks for that camera
  Scene = 3,    ///< a mesh and the instant it is of: from reconstruction to the viewers
  Status = 4,   ///< how a node does: JSON
  Request = 5,  ///< to a node: JSON
  Reply = 6,    ///< from a node: JSON
  Watch = 7,    ///< what its sender wants to be told: to nodes and to reconstruction
};

const char* name_of(MessageKind kind);

/// Raised with every change that an older program would misread; another version is refused, never guessed
/// at.
inline constexpr std::uint16_t kWireVersion = 3;

/// No message is longer; a receiver refuses the rest of a longer one without storing it.
inline constexpr std::size_t kLargestMessage = std::size_t{64} << 20;

/// The longest side of a photograph, and the most pixels of one.
inline constexpr int kLongestSide = 8192;
inline constexpr std::int64_t kMostPixels = 1 << 25;

/// The longest serial that travels.
inline constexpr std::size_t kLongestSerial = 42;

/// What every message begins with: kHeaderBytes bytes, numbers little-endian.
///
///   0 "FSTG"   4 kind   5 serial, padded with zeros   48 version   50 zero   52 bytes after the header
///   56 session   64 sequence   72 epoch   80 instant   88 exposed   96 produced   104 width   108 height
///
/// All versions begin alike up to the version, so that a message of another one is told from one that is
/// none.
struct MessageHeader {
  MessageKind kind = MessageKind::Status;
  std::string serial;         ///< of the camera; empty where a message is of none
  std::uint64_t session = 0;  ///< drawn when its sender began: another one is a sender that began again
  std::uint64_t sequence =
      0;                    ///< of this kind and serial, in this session: a jump is a message that was lost
  std::uint64_t epoch = 0;  ///< as CameraView
  Timestamp instant, exposed, produced;
  int width = 0, height = 0;  ///< px, of the whole photograph
  bool operator==(const MessageHeader&) const = default;
};

inline constexpr std::size_t kHeaderBytes = 112;

/// Header and payload as one message. InvalidArgument for a serial that cannot travel, a picture that is too
/// large, or too long a payload.
Result<std::string> seal(const MessageHeader& header, std::string_view payload);

struct Message {
  MessageHeader header;
  std::string_view payload;  ///< into the bytes that were opened
};

/// Reads the header and finds the payload. BadData when it is no message of ours, or cut off; Unsupported
/// when it is of another version.
Result<Message> open(std::string_view bytes);

/// Writes sender's `session` and `sequence` into a sealed message: they are known last.
void stamp(std::string& sealed, std::uint64_t session, std::uint64_t sequence);

}  // namespace floatstage::studio::wire
