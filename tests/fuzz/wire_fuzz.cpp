#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "studio/messages/control_message.h"
#include "studio/messages/scene_message.h"
#include "studio/messages/view_message.h"
#include "studio/messages/watch_message.h"

using namespace floatstage;

namespace {

// What was read can be written, and says the same again.
template <class Value, class Encode, class Decode>
void expect_round_trip(const Value& value, Encode encode, Decode decode) {
  const Result<std::string> written = encode(value);
  FLOATSTAGE_CHECK(written, "what was read cannot be written: " + written.error().message);
  const Result<studio::wire::Message> opened = studio::wire::open(*written);
  FLOATSTAGE_CHECK(opened, "what was written does not open: " + opened.error().message);
  const auto again = decode(*opened);
  FLOATSTAGE_CHECK(again, "what was written does not decode: " + again.error().message);
  FLOATSTAGE_CHECK(*encode(*again) == *written, "changed by a round trip");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Result<studio::wire::Message> message =
      studio::wire::open({reinterpret_cast<const char*>(data), size});
  if (!message) return 0;
  if (const auto view = studio::wire::decode_view(*message)) {
    if (message->header.kind == studio::wire::MessageKind::Outline)
      expect_round_trip(*view, studio::wire::encode_outline, studio::wire::decode_view);
    const auto as_tile = [](const studio::CameraView& v) {
      return studio::wire::encode_tile(v, {studio::wire::TileCode::Raw, 0});
    };
    if (view->tile) expect_round_trip(*view, as_tile, studio::wire::decode_view);
  }
  if (const auto scene = studio::wire::decode_scene(*message))
    expect_round_trip(*scene, studio::wire::encode_scene, studio::wire::decode_scene);
  if (const auto request = studio::wire::decode_request(*message))
    expect_round_trip(*request, studio::wire::encode_request, studio::wire::decode_request);
  if (const auto status = studio::wire::decode_status(*message))
    expect_round_trip(*status, studio::wire::encode_status, studio::wire::decode_status);
  if (const auto watch = studio::wire::decode_watch(*message))
    expect_round_trip(*watch, studio::wire::encode_watch, studio::wire::decode_watch);
  static_cast<void>(studio::wire::decode_reply(*message));
  return 0;
}
