#include "matting/color_model.h"

#include <algorithm>

namespace floatstage::matting {
namespace {

constexpr float kBlind = 0.02f;  // share of colours drawn blindly
constexpr int kSmoothings = 2;   // passes of a 1-2-1 filter along each axis

}  // namespace

void ColorModel::finish() {
  std::vector<float> line(kSide);
  for (int pass = 0; pass < kSmoothings; ++pass) {
    for (const int step : {1, kSide, kSide * kSide}) {
      for (int start = 0; start < kBins; ++start) {
        if (start / step % kSide != 0) continue;
        for (int i = 0; i < kSide; ++i)
          line[static_cast<std::size_t>(i)] = bins_[static_cast<std::size_t>(start + i * step)];
        for (int i = 0; i < kSide; ++i) {
          const float before = line[static_cast<std::size_t>(std::max(i - 1, 0))],
                      after = line[static_cast<std::size_t>(std::min(i + 1, kSide - 1))];
          bins_[static_cast<std::size_t>(start + i * step)] =
              (before + 2 * line[static_cast<std::size_t>(i)] + after) / 4;
        }
      }
    }
  }
  double sum = 0;
  for (const float b : bins_) sum += b;
  for (float& b : bins_) b = sum > 0 ? (1 - kBlind) * static_cast<float>(b * kBins / sum) + kBlind : 1;
}

}  // namespace floatstage::matting
