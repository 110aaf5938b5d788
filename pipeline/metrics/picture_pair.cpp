#include "pipeline/metrics/picture_pair.h"

#include <algorithm>

#include "core/check.h"
#include "core/text.h"

namespace floatstage::pipeline {

void check_pair(const Image& rendered, const Image& truth, const Image& mask) {
  auto shape = [](const Image& i) { return text(i.width, "x", i.height, "x", i.channels); };
  FLOATSTAGE_CHECK(rendered.width == truth.width && rendered.height == truth.height &&
                       rendered.channels == truth.channels && (truth.channels == 1 || truth.channels == 3),
                   text("metrics compare a picture of ", shape(rendered), " with one of ", shape(truth)));
  FLOATSTAGE_CHECK(mask.width == truth.width && mask.height == truth.height && mask.channels == 1,
                   text("a metric's mask is ", shape(mask), ", its pictures are ", shape(truth)));
}

cv::Rect box_of(const Image& mask) {
  int left = mask.width, right = -1, top = mask.height, bottom = -1;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (*mask.at(x, y) < 128) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
}

cv::Mat luma_of(const Image& image, const cv::Rect& box) {
  cv::Mat luma(box.height, box.width, CV_64F);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const std::uint8_t* p = image.at(box.x + x, box.y + y);
      luma.at<double>(y, x) = image.channels == 1 ? p[0] : 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
    }
  }
  return luma;
}

cv::Mat weights_of(const Image& mask, const cv::Rect& box) {
  cv::Mat weights(box.height, box.width, CV_64F);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x)
      weights.at<double>(y, x) = *mask.at(box.x + x, box.y + y) >= 128 ? 1 : 0;
  return weights;
}

}  // namespace floatstage::pipeline
