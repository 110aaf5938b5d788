#pragma once

#include <optional>
#include <string_view>

#include "capture/take.h"

namespace floatstage::capture {

/// The names in take.json: "ffv1", "raw", "h264".
const char* name_of(TakeCodec codec);
std::optional<TakeCodec> take_codec_named(std::string_view name);

}  // namespace floatstage::capture
