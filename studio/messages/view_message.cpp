#include "studio/messages/view_message.h"

#include "core/check.h"
#include "core/jpeg.h"
#include "core/text.h"
#include "studio/messages/byte_io.h"
#include "studio/messages/matte_runs.h"
#include "studio/messages/outline_code.h"

namespace floatstage::studio::wire {
namespace {

MessageHeader header_of(MessageKind kind, const CameraView& view) {
  MessageHeader header;
  header.kind = kind;
  header.serial = view.serial;
  header.epoch = view.epoch;
  header.instant = view.instant;
  header.exposed = view.exposed;
  header.produced = view.produced;
  header.width = view.width;
  header.height = view.height;
  return header;
}

Unexpected bad(const MessageHeader& header, std::string_view what) {
  return fail(ErrorCode::BadData, text(name_of(header.kind), " of camera '", header.serial, "': ", what));
}

Result<void> read_outline(const Message& message, CameraView& view) {
  ByteReader in(message.payload);
  const auto known = in.get<std::uint8_t>();
  if (!in.good() || known > 1) return bad(message.header, "cut off");
  view.known = known == 1;
  Result<Silhouette> outline = decode_outline_points(in.rest());
  if (!outline) return bad(message.header, outline.error().message);
  view.outline = std::move(*outline);
  return {};
}

Result<void> read_tile(const Message& message, CameraView& view) {
  ByteReader in(message.payload);
  const auto code = in.get<std::uint8_t>();
  auto tile = std::make_shared<ForegroundTile>();
  const auto x = in.get<std::int32_t>(), y = in.get<std::int32_t>(), width = in.get<std::int32_t>(),
             height = in.get<std::int32_t>();
  const std::string_view picture = in.get_bytes(in.get<std::uint32_t>());
  if (!in.good() || code > static_cast<int>(TileCode::Jpeg)) return bad(message.header, "cut off");
  // The header's picture is of a bounded size, and with it the tile.
  if (x < 0 || y < 0 || width < 1 || height < 1 || width > view.width - x || height > view.height - y)
    return bad(message.header, "a tile that is not in its photograph");
  tile->x = x;
  tile->y = y;
  const std::size_t pixels = static_cast<std::size_t>(width) * height;
  if (static_cast<TileCode>(code) == TileCode::Raw) {
    if (picture.size() != 3 * pixels) return bad(message.header, "pixels are missing");
    tile->picture.width = width;
    tile->picture.height = height;
    tile->picture.channels = 3;
    tile->picture.pixels.assign(picture.begin(), picture.end());
  } else {
    Result<Image> decoded = decode_jpeg(as_bytes(picture), width, height);
    if (!decoded) return bad(message.header, decoded.error().message);
    tile->picture = std::move(*decoded);
  }
  Result<std::vector<std::uint8_t>> matte = decode_runs(in.rest(), pixels);
  if (!matte) return bad(message.header, matte.error().message);
  tile->matte.width = width;
  tile->matte.height = height;
  tile->matte.channels = 1;
  tile->matte.pixels = std::move(*matte);
  view.known = true;
  view.tile = std::move(tile);
  return {};
}

}  // namespace

Result<std::string> encode_outline(const CameraView& view) {
  Result<std::string> points = encode_outline_points(view.outline);
  if (!points) return fail(points.error().code, text("camera '", view.serial, "': ", points.error().message));
  return seal(header_of(MessageKind::Outline, view), std::string(1, view.known ? 1 : 0) + *points);
}

Result<std::string> encode_tile(const CameraView& view, const TileOptions& options) {
  FLOATSTAGE_CHECK(view.tile, "a view without a tile");
  const ForegroundTile& tile = *view.tile;
  FLOATSTAGE_CHECK(tile.picture.width == tile.matte.width && tile.picture.height == tile.matte.height &&
                       tile.picture.channels == 3 && tile.matte.channels == 1,
                   "a tile whose matte is not of its picture");
  if (tile.picture.empty())
    return fail(ErrorCode::InvalidArgument, text("camera '", view.serial, "': an empty tile"));
  std::string payload;
  ByteWriter out(payload);
  out.put(static_cast<std::uint8_t>(options.code));
  for (int n : {tile.x, tile.y, tile.picture.width, tile.picture.height})
    out.put(static_cast<std::int32_t>(n));
  const auto put_picture = [&](std::string_view picture) {
    out.put(static_cast<std::uint32_t>(picture.size()));
    out.put_bytes(picture);
  };
  if (options.code == TileCode::Raw)
    put_picture({reinterpret_cast<const char*>(tile.picture.pixels.data()), tile.picture.pixels.size()});
  else
    put_picture(encode_jpeg(tile.picture, options.quality));
  out.put_bytes(encode_runs(tile.matte.pixels));
  return seal(header_of(MessageKind::Tile, view), payload);
}

Result<CameraView> decode_view(const Message& message) {
  const MessageHeader& header = message.header;
  CameraView view;
  view.serial = header.serial;
  view.epoch = header.epoch;
  view.instant = header.instant;
  view.exposed = header.exposed;
  view.produced = header.produced;
  view.width = header.width;
  view.height = header.height;
  if (header.kind != MessageKind::Outline && header.kind != MessageKind::Tile)
    return fail(ErrorCode::BadData, text("a message of kind ", name_of(header.kind), " is no camera's view"));
  const Result<void> read =
      header.kind == MessageKind::Outline ? read_outline(message, view) : read_tile(message, view);
  if (!read) return forward(read);
  return view;
}

}  // namespace floatstage::studio::wire
