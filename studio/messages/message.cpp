#include "studio/messages/message.h"

#include <cstring>

#include "core/check.h"
#include "core/rig.h"
#include "core/text.h"
#include "studio/messages/byte_io.h"

namespace floatstage::studio::wire {
namespace {

constexpr std::string_view kMagic = "FSTG";
constexpr std::size_t kSerialField = kLongestSerial + 1, kSessionAt = 56, kSequenceAt = 64;
// Far enough from the ends that the difference of two stamps is a number too.
constexpr std::int64_t kLatest = std::int64_t{1} << 61;

bool is_kind(std::uint8_t kind) { return kind >= 1 && kind <= 7; }
bool is_of_a_camera(MessageKind kind) { return kind == MessageKind::Outline || kind == MessageKind::Tile; }

bool fits(std::int64_t width, std::int64_t height) {
  return width >= 0 && height >= 0 && width <= kLongestSide && height <= kLongestSide &&
         width * height <= kMostPixels;
}

bool is_stamp(Timestamp t) { return t.ns > -kLatest && t.ns < kLatest; }

// Why the facts of a header cannot be, or nothing.
std::string fault_of(const MessageHeader& header) {
  if (is_of_a_camera(header.kind) && !is_usable_serial(header.serial))
    return text("'", header.serial, "' is no serial of a camera");
  if (!is_of_a_camera(header.kind) && !header.serial.empty()) return "a serial where no camera is meant";
  if (!fits(header.width, header.height))
    return text("a photograph of ", header.width, "x", header.height, " px; at most ", kLongestSide,
                " px a side and ", kMostPixels, " in all travel");
  if (!is_stamp(header.instant) || !is_stamp(header.exposed) || !is_stamp(header.produced))
    return "a time that no clock shows";
  return "";
}

}  // namespace

const char* name_of(MessageKind kind) {
  switch (kind) {
    case MessageKind::Outline:
      return "outline";
    case MessageKind::Tile:
      return "tile";
    case MessageKind::Scene:
      return "scene";
    case MessageKind::Status:
      return "status";
    case MessageKind::Request:
      return "request";
    case MessageKind::Reply:
      return "reply";
    case MessageKind::Watch:
      return "watch";
  }
  return "unknown";
}

Result<std::string> seal(const MessageHeader& header, std::string_view payload) {
  if (const std::string fault = fault_of(header); !fault.empty())
    return fail(ErrorCode::InvalidArgument, text(name_of(header.kind), " message: ", fault));
  if (header.serial.size() > kLongestSerial)
    return fail(ErrorCode::InvalidArgument, text("camera '", header.serial, "': serials of at most ",
                                                 kLongestSerial, " letters travel; give it a shorter one"));
  if (payload.size() > kLargestMessage - kHeaderBytes)
    return fail(ErrorCode::InvalidArgument,
                text(name_of(header.kind), " message: ", payload.size(), " bytes are more than the ",
                     kLargestMessage, " that travel"));
  std::string bytes;
  bytes.reserve(kHeaderBytes + payload.size());
  ByteWriter out(bytes);
  out.put_bytes(kMagic);
  out.put(static_cast<std::uint8_t>(header.kind));
  out.put_bytes(header.serial);
  bytes.append(kSerialField - header.serial.size(), '\0');
  out.put(kWireVersion);
  out.put(std::uint16_t{0});
  out.put(static_cast<std::uint32_t>(payload.size()));
  out.put(header.session);
  out.put(header.sequence);
  out.put(header.epoch);
  for (Timestamp t : {header.instant, header.exposed, header.produced}) out.put(t.ns);
  out.put(static_cast<std::int32_t>(header.width));
  out.put(static_cast<std::int32_t>(header.height));
  FLOATSTAGE_CHECK(bytes.size() == kHeaderBytes, "a header of another length");
  out.put_bytes(payload);
  return bytes;
}

Result<Message> open(std::string_view bytes) {
  const auto bad = [](const std::string& what) { return fail(ErrorCode::BadData, text("message: ", what)); };
  if (!bytes.starts_with(kMagic)) return bad("it does not begin as ours do");
  if (bytes.size() < kHeaderBytes) return bad(text("cut off after ", bytes.size(), " bytes"));
  ByteReader in(bytes.substr(kMagic.size()));
  const auto kind = in.get<std::uint8_t>();
  const std::string_view field = in.get_bytes(kSerialField);
  const auto version = in.get<std::uint16_t>();
  if (version != kWireVersion)
    return fail(ErrorCode::Unsupported, text("message: of version ", version, ", and this program speaks ",
                                             kWireVersion, "; run the same release on every machine"));
  if (!is_kind(kind)) return bad(text("of unknown kind ", static_cast<int>(kind)));
  if (in.get<std::uint16_t>() != 0) return bad("a reserved field is not zero");
  const auto payload = in.get<std::uint32_t>();
  Message message;
  MessageHeader& header = message.header;
  header.kind = static_cast<MessageKind>(kind);
  const std::size_t end = field.find('\0');
  if (end == std::string_view::npos || field.find_first_not_of('\0', end) != std::string_view::npos)
    return bad("the serial does not end with zeros");
  header.serial = field.substr(0, end);
  header.session = in.get<std::uint64_t>();
  header.sequence = in.get<std::uint64_t>();
  header.epoch = in.get<std::uint64_t>();
  for (Timestamp* t : {&header.instant, &header.exposed, &header.produced}) t->ns = in.get<std::int64_t>();
  header.width = in.get<std::int32_t>();
  header.height = in.get<std::int32_t>();
  if (const std::string fault = fault_of(header); !fault.empty()) return bad(fault);
  message.payload = in.rest();
  if (payload != message.payload.size() || bytes.size() > kLargestMessage)
    return bad(text(payload, " bytes were announced and ", message.payload.size(), " are there"));
  return message;
}

void stamp(std::string& sealed, std::uint64_t session, std::uint64_t sequence) {
  FLOATSTAGE_CHECK(sealed.size() >= kHeaderBytes, "no sealed message");
  std::memcpy(sealed.data() + kSessionAt, &session, sizeof session);
  std::memcpy(sealed.data() + kSequenceAt, &sequence, sizeof sequence);
}

}  // namespace floatstage::studio::wire
