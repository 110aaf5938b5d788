#pragma once

#include <bit>

#include "core/image.h"
#include "matting/keyers/bit_rows.h"

// Private to the stage: opacity in bytes and where it reaches a level in bits.
namespace floatstage::matting {

/// In vectors of whatever the processor has. The same bits on all.
struct BitKernels {
  const char* name;  ///< of the instruction set
  /// Bit x % 64 of word x / 64: byte x is at least `level`. Of 64 * words bytes.
  void (*at_least)(const std::uint8_t* bytes, std::size_t words, std::uint8_t level, std::uint64_t* out);
};
std::vector<BitKernels> all_bit_kernels();  ///< all that it has, for tests

/// Bits of `count` bytes, where they are at least `level`, 1 … 255; bits beyond are 0.
void bits_of_row(const std::uint8_t* bytes, int count, int level, std::uint64_t* out);
/// The same of a part of a one-channel picture.
void bits_of(const Image& alpha, const BitBox& box, int level, BitRows& out);
/// Sets the bytes of set bits to `value`.
void set_row(const std::uint64_t* bits, int count, std::uint8_t value, std::uint8_t* bytes);
/// Copies the bytes of set bits.
void copy_row(const std::uint64_t* bits, int count, const std::uint8_t* from, std::uint8_t* to);
/// Squares of 2 * radius + 1 pixels, of any radius.
void dilate_square(BitMorphology& morphology, const BitRows& in, int radius, BitRows& out);
void erode_square(BitMorphology& morphology, const BitRows& in, int radius, BitRows& out);
/// Of what is not 0.
BitBox bounding_box(const Image& alpha);

/// take(x) for each set bit of a row.
template <class Take>
void for_each_bit(const BitRows& picture, int y, const Take& take) {
  const std::uint64_t* row = picture.row(y);
  for (std::size_t w = 0; w < picture.words(); ++w) {
    const int x = static_cast<int>(64 * w);
    if (row[w] == ~std::uint64_t{0})
      for (int i = 0; i < 64; ++i) take(x + i);
    else
      for (std::uint64_t bits = row[w]; bits != 0; bits &= bits - 1) take(x + std::countr_zero(bits));
  }
}

}  // namespace floatstage::matting
