#include "calib/scene_keypoints.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/features2d.hpp>

#include "calib/grey.h"

namespace floatstage::calib {
namespace {

// More scales than usual, and weaker keypoints (MarkerlessOptions::contrast): pictures of a stage are mostly
// backdrop. On the temple ring both take camera centres from 0.22 % of the radius at worst to 0.16 %.
constexpr int kLayers = 5;
constexpr double kEdge = 20, kSigma = 1.6;
// From OpenCV's pixel centres to corners, and back what its enlargement of the picture to twice its size
// shifts: pixel x becomes 2x + 0.5 there, and is divided by two.
constexpr double kCorner = 0.5 - 0.25;

SceneKeypoints::Descriptor roots(const float* d) {
  double sum = 0;
  for (int i = 0; i < 128; ++i) sum += d[i];
  SceneKeypoints::Descriptor out;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] =
        static_cast<std::int16_t>(std::min(255L, std::lround(512 * std::sqrt(d[i] / std::max(sum, 1e-9)))));
  return out;
}

}  // namespace

SceneKeypoints find_keypoints(const Image& picture, double contrast, int most) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(most, kLayers, contrast, kEdge, kSigma);
  std::vector<cv::KeyPoint> found;
  cv::Mat descriptors;
  sift->detectAndCompute(grey_of(picture), cv::noArray(), found, descriptors);
  SceneKeypoints out;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::KeyPoint& k = found[i];
    out.keypoints.push_back({{k.pt.x + kCorner, k.pt.y + kCorner}, k.size, k.angle * std::numbers::pi / 180});
    out.descriptors.push_back(roots(descriptors.ptr<float>(static_cast<int>(i))));
  }
  return out;
}

}  // namespace floatstage::calib
