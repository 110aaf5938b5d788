#include "matting/labels/label_distance.h"

#include <algorithm>
#include <cstdint>

#include <opencv2/imgproc.hpp>

namespace floatstage::matting {

std::vector<float> distance_to(int width, int height, const std::function<bool(int x, int y)>& there) {
  cv::Mat away(height, width, CV_8U);
  bool any = false;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool in = there(x, y);
      away.at<std::uint8_t>(y, x) = in ? 0 : 255;
      any |= in;
    }
  std::vector<float> out(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kFarAway);
  if (!any) return out;
  cv::Mat distance;
  cv::distanceTransform(away, distance, cv::DIST_L2, 3);
  for (int y = 0; y < height; ++y)
    std::copy_n(distance.ptr<float>(y), width, out.begin() + static_cast<std::ptrdiff_t>(y) * width);
  return out;
}

}  // namespace floatstage::matting
