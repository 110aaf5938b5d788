#include "detail/features.h"

#include <algorithm>
#include <cmath>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace floatstage::detail {
namespace {

constexpr int kLongestSide = 1200, kShortestSide = 16;
// From OpenCV's pixel centres to corners, and back what its enlargement of the picture to twice its size
// shifts: pixel x becomes 2x + 0.5 there, and is divided by two (docs/adr/0149).
constexpr double kCorner = 0.5 - 0.25;

}  // namespace

PhotoFeatures find_features(const Image& rgb, int most) {
  PhotoFeatures out;
  out.width = rgb.width;
  out.height = rgb.height;
  if (std::min(rgb.width, rgb.height) < kShortestSide) return out;
  const cv::Mat whole(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.pixels.data()));
  const double shrink = std::min(1.0, static_cast<double>(kLongestSide) / std::max(rgb.width, rgb.height));
  const cv::Size size(std::max(1, static_cast<int>(std::lround(rgb.width * shrink))),
                      std::max(1, static_cast<int>(std::lround(rgb.height * shrink))));
  cv::Mat small = whole, grey;
  if (shrink < 1) cv::resize(whole, small, size, 0, 0, cv::INTER_AREA);
  if (std::min(size.width, size.height) < kShortestSide) return out;
  cv::cvtColor(small, grey, cv::COLOR_RGB2GRAY);
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  cv::SIFT::create(most)->detectAndCompute(grey, cv::noArray(), found, descriptors);
  const Eigen::Vector2d scale(static_cast<double>(rgb.width) / size.width,
                              static_cast<double>(rgb.height) / size.height);
  out.scale = scale.maxCoeff();
  out.descriptors.reserve(found.size() * PhotoFeatures::kLength);
  for (std::size_t i = 0; i < found.size(); ++i) {
    out.points.push_back(
        Eigen::Vector2d(found[i].pt.x + kCorner, found[i].pt.y + kCorner).cwiseProduct(scale));
    out.sizes.push_back(static_cast<float>(found[i].size * out.scale));
    const auto* d = descriptors.ptr<float>(static_cast<int>(i));
    for (int k = 0; k < PhotoFeatures::kLength; ++k)  // whole numbers of 0 to 255 already
      out.descriptors.push_back(static_cast<std::uint8_t>(d[k]));
  }
  return out;
}

}  // namespace floatstage::detail
