#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"
#include "render/flow.h"

namespace floatstage::render {

// Middlebury's .flo (Baker et al., A Database and Evaluation Methodology for Optical Flow, 2011): the float
// 202021.25, width and height as 32-bit integers, then u, v as floats, row by row, all little-endian.

/// Does (u, v) say anything? Middlebury writes numbers beyond 1e9 where the truth is not known.
bool is_known(float u, float v);

/// Reads a field of at most 32768 px a side. Errors name the file: NotFound, Io, BadData where it is not a
/// whole .flo file or has something behind its last pixel.
Result<FlowField> load_flo(const std::filesystem::path& file);
Result<FlowField> decode_flo(std::span<const std::byte> bytes, std::string_view name_for_errors);

/// Writes a field, to a temporary name first. InvalidArgument for one without pixels.
Result<void> save_flo(const FlowField& field, const std::filesystem::path& file);
std::string encode_flo(const FlowField& field);

}  // namespace floatstage::render
