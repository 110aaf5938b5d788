// Bytes become bits in vectors, compiled once for every instruction set that Highway knows here.

#include "matting/keyers/alpha_bits.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/keyers/alpha_bits.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Of whole words.
void at_least(const std::uint8_t* bytes, std::size_t words, std::uint8_t level, std::uint64_t* out) {
  const HWY_CAPPED(std::uint8_t, 64) d;
  if (hn::Lanes(d) < 8) {  // no bytes of bits
    for (std::size_t w = 0; w < words; ++w) {
      out[w] = 0;
      for (std::size_t i = 0; i < 64; ++i)
        out[w] |= static_cast<std::uint64_t>(bytes[64 * w + i] >= level) << i;
    }
    return;
  }
  const auto least = hn::Set(d, level);
  auto* to = reinterpret_cast<std::uint8_t*>(out);
  for (std::size_t x = 0; x < 64 * words; x += hn::Lanes(d)) {
    const auto v = hn::LoadU(d, bytes + x);
    hn::StoreMaskBits(d, hn::Eq(hn::Max(v, least), v), to + x / 8);
  }
}

}  // namespace

void table(BitKernels* out) { *out = {hwy::TargetName(HWY_TARGET), at_least}; }

}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(BitKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

const BitKernels& bit_kernels() {
  static const BitKernels best = native_kernels(fill_table);
  return best;
}

}  // namespace

std::vector<BitKernels> all_bit_kernels() { return kernels_of_all_sets(fill_table); }

void bits_of_row(const std::uint8_t* bytes, int count, int level, std::uint64_t* out) {
  const auto words = static_cast<std::size_t>(count / 64);
  bit_kernels().at_least(bytes, words, static_cast<std::uint8_t>(level), out);
  if (count % 64 == 0) return;
  std::uint64_t last = 0;
  for (int i = 0; i < count % 64; ++i)
    last |= static_cast<std::uint64_t>(bytes[64 * words + static_cast<std::size_t>(i)] >= level) << i;
  out[words] = last;
}

void bits_of(const Image& alpha, const BitBox& box, int level, BitRows& out) {
  out.resize(box.x1 - box.x0, box.y1 - box.y0);
  for (int y = box.y0; y < box.y1; ++y)
    bits_of_row(alpha.at(box.x0, y), out.width(), level, out.row(y - box.y0));
}

namespace {

// take(x, length) for the runs of set bits of a row.
template <class Take>
void for_each_run(const std::uint64_t* bits, int count, const Take& take) {
  for (int x = 0; x < count; x += 64)
    for (std::uint64_t word = *bits++; word != 0;) {
      const int first = std::countr_zero(word), run = std::countr_one(word >> first);
      take(static_cast<std::size_t>(x + first), static_cast<std::size_t>(run));
      if (first + run == 64) break;
      word = word >> (first + run) << (first + run);
    }
}

}  // namespace

void set_row(const std::uint64_t* bits, int count, std::uint8_t value, std::uint8_t* bytes) {
  for_each_run(bits, count, [&](std::size_t x, std::size_t run) { std::memset(bytes + x, value, run); });
}

void copy_row(const std::uint64_t* bits, int count, const std::uint8_t* from, std::uint8_t* to) {
  for_each_run(bits, count, [&](std::size_t x, std::size_t run) { std::memcpy(to + x, from + x, run); });
}

// Made of those that words can do.
void dilate_square(BitMorphology& morphology, const BitRows& in, int radius, BitRows& out) {
  constexpr int most = BitMorphology::kMostRadius;
  morphology.dilate(in, std::min(radius, most), out);
  for (BitRows wide; radius > most; std::swap(wide, out)) {
    radius -= most;
    morphology.dilate(out, std::min(radius, most), wide);
  }
}

void erode_square(BitMorphology& morphology, const BitRows& in, int radius, BitRows& out) {
  constexpr int most = BitMorphology::kMostRadius;
  morphology.erode(in, std::min(radius, most), out);
  for (BitRows narrow; radius > most; std::swap(narrow, out)) {
    radius -= most;
    morphology.erode(out, std::min(radius, most), narrow);
  }
}

BitBox bounding_box(const Image& alpha) {
  BitBox box{alpha.width, alpha.height, 0, 0};
  const std::size_t width = static_cast<std::size_t>(alpha.width);
  const auto something = [](const std::uint8_t* from, std::size_t count) {
    std::uint8_t any = 0;
    for (std::size_t i = 0; i < count; ++i) any |= from[i];
    return any != 0;
  };
  for (int y = 0; y < alpha.height; ++y) {
    const std::uint8_t* row = alpha.at(0, y);
    if (!something(row, width)) continue;
    // Further out than the rows above.
    box.x0 = static_cast<int>(std::find_if(row, row + box.x0, [](std::uint8_t v) { return v != 0; }) - row);
    int last = alpha.width;
    while (last > box.x1 && row[last - 1] == 0) --last;
    box.x1 = last;
    box.y0 = std::min(box.y0, y);
    box.y1 = y + 1;
  }
  return box.empty() ? BitBox{} : box;
}

}  // namespace floatstage::matting
#endif
