#pragma once

#include <string>

#include "core/result.h"
#include "studio/messages/camera_view.h"
#include "studio/messages/message.h"

namespace floatstage::studio::wire {

/// How a tile's picture travels.
enum class TileCode : std::uint8_t {
  Raw = 0,   ///< rows of RGB: for one machine, and where every bit counts
  Jpeg = 1,  ///< a tenth of it (docs/adr/0138)
};

struct TileOptions {
  TileCode code = TileCode::Jpeg;
  int quality = 90;  ///< of the JPEG, 1…100
};

/// The message that always travels: everything of a view but its tile. Points come back to within 1/512 px,
/// and polygons that were apart (recon's kOutlineGap) stay apart. InvalidArgument for what cannot travel: a
/// serial or a picture that is too large, points that are no numbers.
Result<std::string> encode_outline(const CameraView& view);

/// The message for those who asked for this camera's texture. The view must have a tile.
Result<std::string> encode_tile(const CameraView& view, const TileOptions& options);

/// Either message back as a view: of an outline without a tile, of a tile with an empty outline. BadData
/// names the camera. Every size is compared with what can be, and with the bytes that are there, before
/// memory is taken for it.
Result<CameraView> decode_view(const Message& message);

}  // namespace floatstage::studio::wire
