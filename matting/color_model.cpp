#include "matting/color_model.h"

#include <utility>

namespace floatstage::matting {
namespace {

constexpr float kBlind = 0.02f;  // share of colours drawn blindly
constexpr int kSmoothings = 2;   // passes of a 1-2-1 filter along each axis

}  // namespace

void ColorModel::finish() {
  // Lines side by side are smoothed together.
  std::vector<float> lines(static_cast<std::size_t>(kSide) * kSide * kSide);
  for (int pass = 0; pass < kSmoothings; ++pass) {
    for (const std::size_t step : {1, kSide, kSide * kSide}) {
      std::swap(lines, bins_);
      for (std::size_t start = 0; start < bins_.size(); start += kSide * step)
        for (std::size_t i = 0; i < kSide; ++i) {
          const float *here = lines.data() + start + i * step, *before = i > 0 ? here - step : here,
                      *after = i + 1 < kSide ? here + step : here;
          float* out = bins_.data() + start + i * step;
          for (std::size_t k = 0; k < step; ++k) out[k] = (before[k] + 2 * here[k] + after[k]) / 4;
        }
    }
  }
  double sum = 0;
  for (const float b : bins_) sum += b;
  for (float& b : bins_) b = sum > 0 ? (1 - kBlind) * static_cast<float>(b * kBins / sum) + kBlind : 1;
}

}  // namespace floatstage::matting
