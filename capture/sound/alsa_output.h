#pragma once

// Private to capture/.

#include "capture/sound/sound_output.h"

namespace floatstage::capture {

/// A device of ALSA by its name there; `uri` is what errors call it.
Result<std::unique_ptr<SoundOutput>> open_alsa_output(const std::string& device, const std::string& uri);

}  // namespace floatstage::capture
