#pragma once

#include <filesystem>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Whether colours in an EXR with opacity are the subject's own, or multiplied by it, as OpenEXR's convention
/// has it and as programs that put pictures over one another expect.
enum class ExrAlpha { Straight, Associated };

/// RGB, or RGBA with straight alpha, as half-float EXR in linear light (sRGB's curve undone), ZIP-compressed;
/// to a temporary name first. Error: Io.
Result<void> save_exr(const Image& image, const std::filesystem::path& file, ExrAlpha alpha);

}  // namespace floatstage::pipeline
