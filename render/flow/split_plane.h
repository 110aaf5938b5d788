#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "render/flow/aligned_floats.h"

namespace floatstage::render {

/// Columns come in blocks of so many floats of one parity: a multiple of every vector width, so that each
/// instruction set works on the same pixels and no kernel needs a remainder loop.
constexpr int kSplitBlock = 16;

/// One row of a SplitPlane: even[i] is column 2i, odd[i] column 2i + 1. Both may be read and written one
/// block beyond their ends on either side.
struct SplitRow {
  float* even = nullptr;
  float* odd = nullptr;
};
struct ConstSplitRow {
  const float* even = nullptr;
  const float* odd = nullptr;
  ConstSplitRow() = default;
  ConstSplitRow(SplitRow row) : even(row.even), odd(row.odd) {}  // NOLINT(google-explicit-constructor)
  ConstSplitRow(const float* e, const float* o) : even(e), odd(o) {}
};

/// Blocks of a row: [begin, end) in columns of one parity, multiples of kSplitBlock.
struct SplitSpan {
  int begin = 0, end = 0;
  bool empty() const { return begin >= end; }
};

/// A picture of floats with even and odd columns apart. Red and black pixels of a checkerboard are then runs
/// of memory, and the neighbours of a run are runs too: above and below of the same parity and index, left
/// and right of the other parity. Values never written are 0.
class SplitPlane {
 public:
  /// All zero afterwards. Takes memory only when it needs more than it ever had.
  void reset(int width, int height) {
    width_ = width;
    height_ = height;
    half_ = ((width + 1) / 2 + kSplitBlock - 1) / kSplitBlock * kSplitBlock;
    values_.reset(row_floats() * static_cast<std::size_t>(height));
  }
  /// All zero afterwards if the size changed; as it was otherwise.
  void resize(int width, int height) {
    if (width != width_ || height != height_) reset(width, height);
  }
  int width() const { return width_; }
  int height() const { return height_; }
  SplitSpan whole_row() const { return {0, half_}; }
  SplitRow row(int y) {
    float* even = values_.data() + static_cast<std::size_t>(y) * row_floats() + kSplitBlock;
    return {even, even + half_ + kSplitBlock};
  }
  ConstSplitRow row(int y) const { return const_cast<SplitPlane*>(this)->row(y); }
  /// Zeros in the row but for the blocks of `span`.
  void clear_outside(SplitSpan span, int y) {
    const SplitRow r = row(y);
    for (float* half : {r.even, r.odd}) {
      std::fill(half, half + std::min(span.begin, half_), 0.F);
      std::fill(half + std::max(span.begin, span.end), half + half_, 0.F);
    }
  }
  void clear_row(int y) {
    float* begin = values_.data() + static_cast<std::size_t>(y) * row_floats();
    std::fill(begin, begin + row_floats(), 0.F);
  }
  float& at(int x, int y) { return (x % 2 == 0 ? row(y).even : row(y).odd)[x / 2]; }
  float at(int x, int y) const { return const_cast<SplitPlane*>(this)->at(x, y); }

 private:
  std::size_t row_floats() const { return static_cast<std::size_t>(2 * half_ + 3 * kSplitBlock); }

  int width_ = 0, height_ = 0, half_ = 0;
  AlignedFloats values_;
};

/// Deals the columns of a row out to its halves, each times `scale`.
template <class T>
void split_row(const T* from, int width, float scale, SplitRow to) {
  for (int i = 0; i < width / 2; ++i) {
    to.even[i] = static_cast<float>(from[2 * i]) * scale;
    to.odd[i] = static_cast<float>(from[2 * i + 1]) * scale;
  }
  if (width % 2 != 0) to.even[width / 2] = static_cast<float>(from[width - 1]) * scale;
}

/// The way back: the columns of a row in their order.
inline void join_row(ConstSplitRow from, int width, float* to) {
  for (int i = 0; i < width / 2; ++i) {
    to[2 * i] = from.even[i];
    to[2 * i + 1] = from.odd[i];
  }
  if (width % 2 != 0) to[width - 1] = from.even[width / 2];
}

/// Column -1 becomes column 0, and column `width` the last one: what a derivative sees beyond the picture.
inline void replicate_ends(SplitRow row, int width) {
  row.odd[-1] = row.even[0];
  if (width % 2 == 0)
    row.even[width / 2] = row.odd[width / 2 - 1];
  else
    row.odd[width / 2] = row.even[width / 2];
}

}  // namespace floatstage::render
