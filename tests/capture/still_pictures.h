#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace floatstage::capture {

/// The bytes of a picture file whose samples are what `sample(x, y, component)` says, in the encoder's own
/// pixel format: encode_still("png", "rgb48be", …), encode_still("mjpeg", "yuvj444p", …). Empty when this
/// libavcodec cannot.
std::string encode_still(const char* encoder, const char* pixel_format, int width, int height,
                         const std::function<unsigned(int x, int y, int component)>& sample);

}  // namespace floatstage::capture
