#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/result.h"
#include "matting/spectral/spectral_matting.h"

// Private to the stage: eigenpairs and components as files.
namespace floatstage::matting {

/// Rounds every column to 16 bits of its largest entry, as the files keep it. What continues from a file then
/// continues exactly as it would have without.
void quantize(Eigen::MatrixXf& columns);

/// Files of one frame. `key` says which picture and options they were made from. Layout (little endian):
/// magic "fsspect\n", u32 version 1, u32 kind (1 eigenpairs, 2 components), u32 width, height, columns, u32
/// 0, u64 key, f64 residual, f64 value a column, f32 scale a column, i16 entries column by column, u64
/// hash_of() all before.
std::string to_bytes(const EigenPairs& pairs, std::uint64_t key);
std::string to_bytes(const MattingComponents& components, std::uint64_t key);

/// BadData naming the file and what is wrong: cut off, damaged, another version or kind.
Result<EigenPairs> parse_eigenpairs(std::string_view bytes, std::uint64_t& key, std::string_view name);
Result<MattingComponents> parse_components(std::string_view bytes, std::uint64_t& key, std::string_view name);

/// FNV-1a by words of eight bytes, continued from `hash`.
std::uint64_t hash_of(std::string_view bytes, std::uint64_t hash = 14695981039346656037u);

}  // namespace floatstage::matting
