#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "capture/sound/play_out.h"
#include "core/result.h"

namespace floatstage::capture {

/// What is heard in a film, kPlayOutRate samples a second.
struct FilmSound {
  int channels = 1;  ///< one or two
  std::int64_t samples = 0;
  /// The samples from `first` on, all channels in turn; called in their order.
  std::function<Result<void>(std::int64_t first, std::span<float> interleaved)> read;
};

}  // namespace floatstage::capture
