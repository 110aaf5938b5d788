#pragma once

#include <opencv2/core.hpp>

#include "core/image.h"

namespace floatstage::calib {

/// The picture as 8-bit grey; shares the pixels of a grey image, which must outlive it. Private to calib.
cv::Mat grey_of(const Image& image);

/// Grey at a place between pixel centres (OpenCV's convention: first centre at 0), clamped to the picture.
inline float grey_at(const cv::Mat& grey, float x, float y) {
  x = std::min(std::max(x, 0.0f), static_cast<float>(grey.cols - 1));
  y = std::min(std::max(y, 0.0f), static_cast<float>(grey.rows - 1));
  const int u = std::min(static_cast<int>(x), grey.cols - 2),
            v = std::min(static_cast<int>(y), grey.rows - 2);
  const float a = x - static_cast<float>(u), b = y - static_cast<float>(v);
  const std::uint8_t* p = grey.ptr<std::uint8_t>(v) + u;
  const std::uint8_t* q = p + grey.step;
  return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1]);
}

}  // namespace floatstage::calib
