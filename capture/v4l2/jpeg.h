#pragma once

#include <cstddef>
#include <span>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// A picture of a Motion-JPEG stream as RGB, by libturbojpeg. BadData when the bytes are no whole JPEG, or
/// not of this size.
Result<Image> decode_jpeg(std::span<const std::byte> jpeg, int width, int height);

}  // namespace floatstage
