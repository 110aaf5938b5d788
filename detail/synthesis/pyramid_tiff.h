#pragma once

#include <filesystem>
#include <memory>

#include "core/result.h"
#include "detail/synthesis/row_writer.h"

namespace floatstage::detail {

/// A picture as a tiled pyramid in one TIFF, as libvips and OpenSlide read it: directories of ever half the
/// size, JPEG tiles of 256 px, BigTIFF where it may pass four gigabytes. Smaller levels wait in a second file
/// beside it until the picture is whole. Without finish() both are removed. Io.
Result<std::unique_ptr<RowWriter>> write_pyramid_tiff(const std::filesystem::path& file, int width,
                                                      int height);

}  // namespace floatstage::detail
