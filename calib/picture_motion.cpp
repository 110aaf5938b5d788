#include "calib/picture_motion.h"

#include <algorithm>
#include <array>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "calib/markerless.h"
#include "calib/scene_matching.h"
#include "core/statistics.h"

namespace floatstage::calib {

PictureMotion picture_motion(const Image& from, const Image& to, double contrast) {
  constexpr int kMost = 2000;      // keypoints: enough for shares
  constexpr double kNear = 0.003;  // of the longer side: what a homography may miss
  constexpr std::size_t kFew = 8;  // twice what a homography needs
  const std::array pictures{find_keypoints(from, contrast, kMost), find_keypoints(to, contrast, kMost)};
  const std::vector<SceneMatches> pairs = match_pictures(pictures, 1);
  PictureMotion out;
  if (pairs.front().matches.size() < kFew) return out;
  const double side = std::max(from.width, from.height);
  std::vector<cv::Point2f> before, after;
  std::vector<double> shifts;
  for (const SceneMatches::Match& m : pairs.front().matches) {
    const Eigen::Vector2d a = pictures[0].keypoints[static_cast<std::size_t>(m.i)].pixel,
                          b = pictures[1].keypoints[static_cast<std::size_t>(m.k)].pixel;
    before.emplace_back(static_cast<float>(a.x()), static_cast<float>(a.y()));
    after.emplace_back(static_cast<float>(b.x()), static_cast<float>(b.y()));
    shifts.push_back((b - a).norm() / side);
  }
  std::vector<unsigned char> explained;
  cv::findHomography(before, after, explained, cv::RANSAC, kNear * side);
  out.matches = static_cast<int>(before.size());
  out.shift = median(std::move(shifts));
  out.turned = static_cast<double>(std::count(explained.begin(), explained.end(), 1)) /
               static_cast<double>(before.size());
  return out;
}

}  // namespace floatstage::calib
