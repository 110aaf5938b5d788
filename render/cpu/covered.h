#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage::render::cpu {

/// The pixels of a window that the proxy covers, as runs of each row. What is computed for covered pixels
/// alone lies in lists, row after row; every row's part begins on a multiple of kAlign, so that a vector's
/// last step may write beyond its row's pixels, and `padded` is the lists' length.
struct Covered {
  static constexpr int kAlign = 16;
  struct Span {
    int begin, end;    ///< x of its first pixel, and of the one after its last
    std::size_t list;  ///< of its first pixel, in the lists
  };
  struct Row {
    std::size_t first_span, last_span;  ///< its spans are [first_span, last_span)
    std::size_t list;                   ///< of its first pixel
    int count;                          ///< pixels
  };

  void find(int width, int height, const float* inverse_z);  ///< 0: not covered

  std::vector<Span> spans;
  std::vector<Row> rows;
  std::vector<float> x;          ///< list: pixels' centres
  std::vector<float> inverse_z;  ///< list
  std::size_t padded = 0;
};

}  // namespace floatstage::render::cpu
