#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Whether colours in an EXR with opacity are the subject's own, or multiplied by it, as OpenEXR's convention
/// has it and as programs that put pictures over one another expect.
enum class ExrAlpha { Straight, Associated };

/// One opacity more, beside that of the picture: the channel `<name>.A`, which compositing programs show as
/// the alpha of a layer of that name.
struct ExrLayer {
  std::string name;      ///< without a dot
  const Image& opacity;  ///< one channel, of the picture's size
};

/// RGB, or RGBA with straight alpha, as half-float EXR in linear light (sRGB's curve undone), ZIP-compressed;
/// to a temporary name first. Error: Io.
Result<void> save_exr(const Image& image, const std::filesystem::path& file, ExrAlpha alpha,
                      const std::vector<ExrLayer>& layers = {});

/// The names of a file's channels, sorted; none where it is no EXR.
std::vector<std::string> exr_channels(const std::filesystem::path& file);

}  // namespace floatstage::pipeline
