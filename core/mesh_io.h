#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "core/mesh.h"
#include "core/result.h"

namespace floatstage {

/// Binary little-endian PLY (positions as float, faces as uchar + int lists), and GLB for others' viewers
/// (world is z up here, y up there: the node carries the rotation). Written to a temporary name and renamed.
Result<void> save_ply(const Mesh& mesh, const std::filesystem::path& file);
Result<void> save_glb(const Mesh& mesh, const std::filesystem::path& file);

/// Reads ASCII or binary PLY with any vertex properties; polygons are cut into fans. Errors name the file:
/// BadData for truncation, indices out of range, NaN positions.
Result<Mesh> load_ply(const std::filesystem::path& file);
Result<Mesh> parse_ply(std::span<const std::byte> bytes, std::string_view name_for_errors);

}  // namespace floatstage
