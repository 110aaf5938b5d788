#pragma once

#include <filesystem>
#include <memory>

#include "core/result.h"
#include "detail/synthesis/row_writer.h"

namespace floatstage::detail {

/// write_deep_zoom()'s tiles: NAME_files beside NAME.dzi.
std::filesystem::path deep_zoom_tiles(const std::filesystem::path& file);

/// A picture as a Deep Zoom image: `file` (NAME.dzi), and tiles of 254 px with a pixel of their neighbours
/// around them as JPEGs in NAME_files/LEVEL/COLUMN_ROW.jpg, each level half of the next, down to one pixel.
/// The document comes last: while it is not there, the image is not whole. Io.
Result<std::unique_ptr<RowWriter>> write_deep_zoom(const std::filesystem::path& file, int width, int height);

}  // namespace floatstage::detail
