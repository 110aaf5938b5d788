// Method:  the order in which a grid's pixels are eliminated:
//          halves first, the line between them last
// Paper:   A. George, "Nested dissection of a regular finite element mesh", 1973
// Differs: lines are two pixels wide, since neighbours reach two rows far
// ADR:     0091

#include "matting/spectral/nested_dissection.h"

#include <cstddef>

namespace floatstage::matting {
namespace {

constexpr int kSeparator = 2;  // what a 3x3 window couples is at most two rows and columns apart
constexpr int kLeaf = 6;       // px: smaller rectangles fill up anyway

struct Dissection {
  int width;
  std::vector<int> order;

  void list(int x0, int y0, int x1, int y1, bool by_columns) {
    if (by_columns) {
      for (int x = x0; x < x1; ++x)
        for (int y = y0; y < y1; ++y) order.push_back(y * width + x);
    } else {
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) order.push_back(y * width + x);
    }
  }

  void cut(int x0, int y0, int x1, int y1) {
    const int w = x1 - x0, h = y1 - y0;
    if (w <= 0 || h <= 0) return;
    if (w <= kLeaf && h <= kLeaf) return list(x0, y0, x1, y1, w > h);
    if (w >= h) {
      const int middle = x0 + (w - kSeparator) / 2;
      cut(x0, y0, middle, y1);
      cut(middle + kSeparator, y0, x1, y1);
      list(middle, y0, middle + kSeparator, y1, false);
    } else {
      const int middle = y0 + (h - kSeparator) / 2;
      cut(x0, y0, x1, middle);
      cut(x0, middle + kSeparator, x1, y1);
      list(x0, middle, x1, middle + kSeparator, true);
    }
  }
};

}  // namespace

std::vector<int> nested_dissection(int width, int height) {
  Dissection dissection{width, {}};
  dissection.order.reserve(static_cast<std::size_t>(width) * height);
  dissection.cut(0, 0, width, height);
  return std::move(dissection.order);
}

}  // namespace floatstage::matting
