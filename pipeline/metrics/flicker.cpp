#include <cmath>
#include <cstdlib>

#include "core/check.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/metrics/picture_pair.h"

namespace floatstage::pipeline {

PictureError picture_error(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  PictureError error{Image(mask.width, mask.height, 1), {}};
  const auto channels = static_cast<std::size_t>(truth.channels);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (mask.pixels[i] < 128) continue;
    error.mask.pixels[i] = 255;
    for (std::size_t c = channels * i; c < channels * (i + 1); ++c)
      error.differences.push_back(static_cast<std::int16_t>(rendered.pixels[c] - truth.pixels[c]));
  }
  return error;
}

double flicker(const PictureError& now, const PictureError& before) {
  if (now.mask.width != before.mask.width || now.mask.height != before.mask.height) return Scores::kUnknown;
  const auto of_a_pixel = [](const PictureError& e) {
    std::size_t pixels = 0;
    for (const std::uint8_t m : e.mask.pixels) pixels += m >= 128;
    return pixels > 0 ? e.differences.size() / pixels : 0;
  };
  const std::size_t channels = of_a_pixel(now);
  FLOATSTAGE_CHECK(channels == of_a_pixel(before) || now.differences.empty() || before.differences.empty(),
                   "errors of pictures with as many channels");
  double sum = 0, count = 0;
  std::size_t here = 0, there = 0;  // the pixels' places among the differences
  for (std::size_t i = 0; i < now.mask.pixels.size(); ++i) {
    const bool in_now = now.mask.pixels[i] >= 128, in_before = before.mask.pixels[i] >= 128;
    if (in_now && in_before) {
      for (std::size_t c = 0; c < channels; ++c)
        sum += std::abs(now.differences[here + c] - before.differences[there + c]);
      count += static_cast<double>(channels);
    }
    if (in_now) here += channels;
    if (in_before) there += channels;
  }
  return count > 0 ? sum / count : Scores::kUnknown;
}

}  // namespace floatstage::pipeline
