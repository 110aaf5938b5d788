// Method:  dilation and erosion by a disc as rows that are widened step by step
// Paper:   mathematical morphology: J. Serra, "Image analysis and mathematical morphology", 1982
// Differs: nothing: OpenCV's bytes, without its memory for every call

#include "matting/keyers/byte_closing.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "matting/keyers/row_kernels.h"
#include "matting/keyers/row_measure.h"

namespace floatstage::matting {
namespace {

// Half a row of OpenCV's ellipse, dy off its middle.
int half_row(int radius, int dy) {
  return static_cast<int>(
      std::lrint(radius * std::sqrt((radius * radius - dy * dy) / static_cast<double>(radius * radius))));
}

}  // namespace

void ByteClosing::resize(int width, int height) {
  width_ = width;
  height_ = height;
  stride_ = padded(static_cast<std::size_t>(width));
  picture_.resize(stride_ * static_cast<std::size_t>(height));
}

void ByteClosing::close(int radius) {
  if (radius <= 0 || width_ == 0) return;
  around<true>(radius, picture_, grown_);
  around<false>(radius, grown_, picture_);
}

template <bool kLargest>
void ByteClosing::around(int radius, const std::vector<std::uint8_t>& in, std::vector<std::uint8_t>& out) {
  const auto join = kLargest ? row_kernels().raise : row_kernels().lower;
  const std::uint8_t nothing = kLargest ? 0 : 255;
  const std::size_t width = static_cast<std::size_t>(width_), apron = static_cast<std::size_t>(radius);
  out.assign(stride_ * static_cast<std::size_t>(height_), nothing);
  row_.assign(width + 2 * apron, nothing);
  wide_.resize(width);
  for (int y = 0; y < height_; ++y) {
    std::uint8_t* middle = row_.data() + apron;
    std::memcpy(middle, in.data() + stride_ * static_cast<std::size_t>(y), width);
    std::memcpy(wide_.data(), middle, width);
    // From the narrowest row of the disc to its widest, so that rows are widened further and never anew.
    int widened = 0;
    for (int dy = radius; dy >= 0; --dy) {
      for (const int half = half_row(radius, dy); widened < half;) {
        ++widened;
        join(middle - widened, width, wide_.data());
        join(middle + widened, width, wide_.data());
      }
      for (const int to : {y - dy, y + dy}) {
        if (to >= 0 && to < height_)
          join(wide_.data(), width, out.data() + stride_ * static_cast<std::size_t>(to));
      }
    }
  }
}

}  // namespace floatstage::matting
