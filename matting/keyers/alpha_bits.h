#pragma once

#include "core/image.h"
#include "matting/keyers/bit_rows.h"

// Private to the stage: opacity in bytes and where it reaches a level in bits.
namespace floatstage::matting {

/// Bits of `count` bytes, where they are at least `level`, 1 … 128; bits beyond are 0.
void bits_of_row(const std::uint8_t* bytes, int count, int level, std::uint64_t* out);
/// The same of a part of a one-channel picture.
void bits_of(const Image& alpha, const BitBox& box, int level, BitRows& out);
/// Sets the bytes of set bits to `value`.
void set_row(const std::uint64_t* bits, int count, std::uint8_t value, std::uint8_t* bytes);
/// Of what is not 0.
BitBox bounding_box(const Image& alpha);

}  // namespace floatstage::matting
