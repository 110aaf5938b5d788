#pragma once

#include <cstdint>
#include <filesystem>
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

/// A file of it alone, coded as a film of that name has its sound (media_file.h: AAC where it ends in .m4a),
/// the same bytes each time. Temporary name until it is whole; AlreadyExists when `file` is there or is being
/// written; Io.
Result<void> write_sound(const FilmSound& sound, const std::filesystem::path& file);

}  // namespace floatstage::capture
