#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/view_message.h"

using namespace floatstage;

namespace {

// What was read can be written, and says the same again.
template <class Value, class Encode, class Decode>
void expect_round_trip(const Value& value, Encode encode, Decode decode) {
  const Result<std::string> written = encode(value);
  FLOATSTAGE_CHECK(written, "what was read cannot be written: " + written.error().message);
  const Result<wire::Message> opened = wire::open(*written);
  FLOATSTAGE_CHECK(opened, "what was written does not open: " + opened.error().message);
  const auto again = decode(*opened);
  FLOATSTAGE_CHECK(again, "what was written does not decode: " + again.error().message);
  FLOATSTAGE_CHECK(*encode(*again) == *written, "changed by a round trip");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Result<wire::Message> message = wire::open({reinterpret_cast<const char*>(data), size});
  if (!message) return 0;
  if (const auto view = wire::decode_view(*message)) {
    if (message->header.kind == wire::MessageKind::Outline)
      expect_round_trip(*view, wire::encode_outline, wire::decode_view);
    const auto as_tile = [](const CameraView& v) { return wire::encode_tile(v, {wire::TileCode::Raw, 0}); };
    if (view->tile) expect_round_trip(*view, as_tile, wire::decode_view);
  }
  if (const auto scene = wire::decode_scene(*message))
    expect_round_trip(*scene, wire::encode_scene, wire::decode_scene);
  if (const auto request = wire::decode_request(*message))
    expect_round_trip(*request, wire::encode_request, wire::decode_request);
  if (const auto status = wire::decode_status(*message))
    expect_round_trip(*status, wire::encode_status, wire::decode_status);
  static_cast<void>(wire::decode_reply(*message));
  return 0;
}
