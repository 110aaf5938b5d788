#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// A JPEG as RGB, by libturbojpeg: a picture of a Motion-JPEG stream, or of the network. BadData when the
/// bytes are no whole JPEG, or not of this size; memory is taken only for this size.
Result<Image> decode_jpeg(std::span<const std::byte> jpeg, int width, int height);

/// An RGB picture as JPEG with colour at full resolution (4:4:4). `quality` is the usual 1…100.
std::string encode_jpeg(const Image& rgb, int quality);

}  // namespace floatstage
