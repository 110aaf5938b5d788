#pragma once

// Private to capture/: libav plays a WAV file that was cut off as if it were whole.

#include <filesystem>

#include "core/result.h"

namespace floatstage::capture {

/// Whether a RIFF, RF64 or BW64 file holds all the sound that its header states, and what follows that are
/// chunks, a thousand at most (libav would look for more through gigabytes of zeros): BadData says what is
/// wrong. Of a file of another kind, or one that states no length (0xFFFFFFFF, written into a pipe), there is
/// nothing to say. NotFound, Io.
Result<void> check_wav_length(const std::filesystem::path& file);

}  // namespace floatstage::capture
