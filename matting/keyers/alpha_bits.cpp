#include "matting/keyers/alpha_bits.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace floatstage::matting {
namespace {

static_assert(std::endian::native == std::endian::little, "the first byte of a word is its lowest");

// Bit i: byte i of eight is at least `level`.
std::uint64_t bits_of_eight(std::uint64_t bytes, std::uint64_t missing) {
  constexpr std::uint64_t kTop = 0x8080808080808080, kGather = 0x0002040810204081;
  return (((((bytes & ~kTop) + missing) | bytes) & kTop) * kGather) >> 56;
}

std::uint64_t load(const std::uint8_t* bytes) {
  std::uint64_t eight;
  std::memcpy(&eight, bytes, sizeof eight);
  return eight;
}

}  // namespace

void bits_of_row(const std::uint8_t* bytes, int count, int level, std::uint64_t* out) {
  const std::uint64_t missing = 0x0101010101010101 * static_cast<std::uint64_t>(128 - level);
  int x = 0;
  for (; x + 64 <= count; x += 64) {
    std::uint64_t word = 0;
    for (int i = 0; i < 8; ++i) word |= bits_of_eight(load(bytes + x + 8 * i), missing) << (8 * i);
    *out++ = word;
  }
  if (x == count) return;
  std::uint64_t word = 0;
  for (int i = 0; x + i < count; ++i) word |= static_cast<std::uint64_t>(bytes[x + i] >= level) << i;
  *out = word;
}

void bits_of(const Image& alpha, const BitBox& box, int level, BitRows& out) {
  out.resize(box.x1 - box.x0, box.y1 - box.y0);
  for (int y = box.y0; y < box.y1; ++y)
    bits_of_row(alpha.at(box.x0, y), out.width(), level, out.row(y - box.y0));
}

void set_row(const std::uint64_t* bits, int count, std::uint8_t value, std::uint8_t* bytes) {
  for (int x = 0; x < count; x += 64) {
    std::uint64_t word = *bits++;
    std::uint8_t* to = bytes + x;
    while (word != 0) {
      const int first = std::countr_zero(word), run = std::countr_one(word >> first);
      std::memset(to + first, value, static_cast<std::size_t>(run));
      if (first + run == 64) break;
      word = word >> (first + run) << (first + run);
    }
  }
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
    int first = 0, last = alpha.width;
    while (row[first] == 0) ++first;
    while (row[last - 1] == 0) --last;
    box = {std::min(box.x0, first), std::min(box.y0, y), std::max(box.x1, last), y + 1};
  }
  return box.empty() ? BitBox{} : box;
}

}  // namespace floatstage::matting
