#include "studio/messages/watch_message.h"

#include <array>

#include "core/rig.h"
#include "core/text.h"
#include "studio/messages/byte_io.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::array kTold = {MessageKind::Outline, MessageKind::Tile, MessageKind::Scene,
                              MessageKind::Status};

constexpr std::uint8_t bit_of(MessageKind kind) {
  return static_cast<std::uint8_t>(1u << static_cast<unsigned>(kind));
}

}  // namespace

// 0 kinds, a bit each   1 zero   2 number of serials   4 the serials: length and letters, in ascending order
Result<std::string> encode_watch(const Watch& watch) {
  const auto refuse = [](const std::string& what) {
    return fail(ErrorCode::InvalidArgument, text("watch message: ", what));
  };
  std::uint8_t kinds = 0;
  for (MessageKind kind : kTold)
    if (watch.kinds.contains(kind)) kinds |= bit_of(kind);
  for (MessageKind kind : watch.kinds)
    if ((kinds & bit_of(kind)) == 0) return refuse(text("nobody is told of a ", name_of(kind)));
  if (watch.tiles.size() > kMostWatched)
    return refuse(text("tiles of ", watch.tiles.size(), " cameras; at most ", kMostWatched,
                       " may be asked for by name"));
  std::string payload;
  ByteWriter out(payload);
  out.put(kinds);
  out.put(std::uint8_t{0});
  out.put(static_cast<std::uint16_t>(watch.tiles.size()));
  for (const std::string& serial : watch.tiles) {
    if (!is_usable_serial(serial) || serial.size() > kLongestSerial)
      return refuse(text("'", serial, "' is no serial that travels"));
    out.put(static_cast<std::uint8_t>(serial.size()));
    out.put_bytes(serial);
  }
  MessageHeader header;
  header.kind = MessageKind::Watch;
  return seal(header, payload);
}

Result<Watch> decode_watch(const Message& message) {
  const auto bad = [](const std::string& what) {
    return fail(ErrorCode::BadData, text("watch message: ", what));
  };
  if (message.header.kind != MessageKind::Watch) return bad("of another kind");
  ByteReader in(message.payload);
  const auto kinds = in.get<std::uint8_t>();
  const auto zero = in.get<std::uint8_t>();
  const auto count = in.get<std::uint16_t>();
  if (!in.good() || zero != 0) return bad("it does not begin as it should");
  if (count > kMostWatched) return bad(text("tiles of ", count, " cameras; at most ", kMostWatched));
  Watch watch;
  std::uint8_t known = 0;
  for (MessageKind kind : kTold) {
    known |= bit_of(kind);
    if ((kinds & bit_of(kind)) != 0) watch.kinds.insert(kind);
  }
  if ((kinds & ~known) != 0) return bad("of kinds that nobody is told");
  for (int i = 0; i < count; ++i) {
    const std::string serial(in.get_bytes(in.get<std::uint8_t>()));
    if (!is_usable_serial(serial) || serial.size() > kLongestSerial)
      return bad(text("serial ", i + 1, " of ", count, " is none"));
    if (!watch.tiles.empty() && serial <= *watch.tiles.rbegin()) return bad("serials are not in order");
    watch.tiles.insert(watch.tiles.end(), serial);
  }
  if (!in.done()) return bad("bytes are left over");
  return watch;
}

}  // namespace floatstage::studio::wire
