#pragma once

#include "render/flow/split_plane.h"

namespace floatstage::render {

/// The last few rows of something that is made row after row.
class RowRing {
 public:
  /// `rows`: a power of two.
  void reset(int width, int rows) {
    rows_.resize(width, rows);
    mask_ = rows - 1;
  }
  SplitRow operator[](int y) { return rows_.row(y & mask_); }
  void clear(int y) { rows_.clear_row(y & mask_); }

  /// How many rows a ring needs for `least` of them.
  static int rows_for(int least) {
    int rows = 1;
    while (rows < least) rows *= 2;
    return rows;
  }

 private:
  SplitPlane rows_;
  int mask_ = 0;
};

}  // namespace floatstage::render
