#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "matting/keyers/keyer_choice.h"

namespace floatstage::studio {

/// A camera's clean plates (capture::load_plates()), or nothing where the folder has none or is not named.
Result<matting::KeySamples> empty_stage_of(const std::filesystem::path& plates, const std::string& serial);

}  // namespace floatstage::studio
