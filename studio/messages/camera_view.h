#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/image.h"
#include "core/silhouette.h"
#include "core/time.h"

namespace floatstage::studio {

/// The part of a photograph that shows the subject: a rectangle of it, in the photograph's own pixels.
struct ForegroundTile {
  int x = 0, y = 0;  ///< of the rectangle's first pixel
  Image picture;     ///< RGB
  Image matte;       ///< one channel, same size
};

/// What a camera node hands on of one camera and one instant: all that reconstruction (the outline) and the
/// view (the tile) need of it. In one process it is passed by shared pointer; between machines as one
/// message.
struct CameraView {
  std::string serial;
  std::uint64_t epoch =
      0;               ///< number of the instant since the node's session began: equal for all its cameras
  Timestamp instant;   ///< middle of the set's exposures, on the studio clock
  Timestamp exposed;   ///< this camera's own exposure
  Timestamp produced;  ///< when the picture was: latency counts from here (CameraTime::produced)
  int width = 0, height = 0;  ///< px, of the whole photograph
  bool known = false;         ///< false: the camera missed the instant; it does not carve and has no tile
  Silhouette outline;         ///< px of the photograph
  std::shared_ptr<const ForegroundTile> tile;  ///< null when nobody asked for this camera's texture
};

}  // namespace floatstage::studio
