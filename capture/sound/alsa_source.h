#pragma once

// Private to capture/.

#include "capture/sound/sound_source.h"

namespace floatstage::capture {

/// A device of ALSA by its name there ("hw:0", "default"); `uri` is what errors call it.
Result<std::unique_ptr<SoundSource>> open_alsa(const std::string& device, const std::string& uri);

}  // namespace floatstage::capture
