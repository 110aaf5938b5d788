#include "capture/take_codec.h"

#include <array>

namespace floatstage::capture {
namespace {
constexpr std::array<const char*, 3> kNames = {"ffv1", "raw", "h264"};
}

const char* name_of(TakeCodec codec) { return kNames[static_cast<std::size_t>(codec)]; }

std::optional<TakeCodec> take_codec_named(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames[i]) return static_cast<TakeCodec>(i);
  return std::nullopt;
}

}  // namespace floatstage::capture
