// Method:  corners that stay where they are, counted by cells of the picture
// Paper:   B. Lucas, T. Kanade, "An iterative image registration technique", 1981, in J.-Y. Bouguet's
// pyramids,
//          2000; J. Shi, C. Tomasi, "Good features to track", 1994
// Differs: no motion is fitted: a plate asks only whether the place stood still, and a count of cells
//          is not led astray by one performer full of corners
// ADR:     0197

#include "matting/camera_motion.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/check.h"
#include "core/statistics.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr int kLongSide = 640;  // px: at which corners are followed
constexpr int kCells = 8;       // of the grid, across and down
constexpr int kCornersACell = 8;
constexpr double kStill = 0.5;         // px at that size: what noise and compression shake a corner by, twice
constexpr double kThereAndBack = 0.5;  // px: a corner that does not come back to itself was not found again
constexpr double kContrast = 6;  // 8-bit steps: least eigenvalue of a corner, as a step across its window
constexpr int kFewestCells = kCells;     // that show corners: as many as one row …
constexpr double kSpread = 0.75;         // … but spread over so much of the rows and columns
constexpr double kStillShare = 1.0 / 3;  // of the cells with corners, where the camera stood still

cv::Mat working(const Image& picture) {
  const double scale =
      std::min(1.0, static_cast<double>(kLongSide) / std::max(picture.width, picture.height));
  const cv::Mat view(picture.height, picture.width, CV_8UC3,
                     const_cast<std::uint8_t*>(picture.pixels.data()));
  cv::Mat grey, small;
  cv::cvtColor(view, grey, cv::COLOR_RGB2GRAY);
  cv::resize(grey, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

// The strongest corners of each cell.
std::vector<std::vector<cv::Point2f>> corners_of(const cv::Mat& grey) {
  constexpr int kWindow = 5, kPeak = 7, kRim = 8;  // px
  cv::Mat strength;
  cv::cornerMinEigenVal(grey, strength, kWindow, 3);
  const double least = kContrast * kContrast / (255.0 * 255.0);
  std::vector<std::vector<cv::Point2f>> cells(kCells * kCells);
  cv::Mat peak;
  cv::dilate(strength, peak, cv::Mat::ones(kPeak, kPeak, CV_8U));
  for (int cy = 0; cy < kCells; ++cy)
    for (int cx = 0; cx < kCells; ++cx) {
      std::vector<std::pair<float, cv::Point2f>> found;
      for (int y = cy * grey.rows / kCells; y < (cy + 1) * grey.rows / kCells; ++y)
        for (int x = cx * grey.cols / kCells; x < (cx + 1) * grey.cols / kCells; ++x) {
          const float s = strength.at<float>(y, x);
          if (s >= least && s >= peak.at<float>(y, x) && x >= kRim && y >= kRim && x < grey.cols - kRim &&
              y < grey.rows - kRim)
            found.emplace_back(-s, cv::Point2f(static_cast<float>(x), static_cast<float>(y)));
        }
      std::stable_sort(found.begin(), found.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      if (found.size() > kCornersACell) found.resize(kCornersACell);
      for (const auto& f : found) cells[static_cast<std::size_t>(cy * kCells + cx)].push_back(f.second);
    }
  return cells;
}

}  // namespace

CameraStillness stillness_between(const Image& a, const Image& b) {
  FLOATSTAGE_CHECK(a.width == b.width && a.height == b.height && a.channels == 3 && b.channels == 3,
                   "stillness");
  CameraStillness out;
  if (std::min(a.width, a.height) < 32) return out;
  const cv::Mat first = working(a), second = working(b);
  const std::vector<std::vector<cv::Point2f>> cells = corners_of(first);
  std::vector<cv::Point2f> from, to, back;
  for (const auto& cell : cells) from.insert(from.end(), cell.begin(), cell.end());
  if (from.empty()) return out;
  std::vector<std::uint8_t> there, again;
  std::vector<float> error;
  const cv::Size window(15, 15);
  cv::calcOpticalFlowPyrLK(first, second, from, to, there, error, window, 4);
  cv::calcOpticalFlowPyrLK(second, first, to, back, again, error, window, 4);
  std::vector<double> ways;
  std::size_t k = 0;
  bool rows[kCells] = {}, columns[kCells] = {};
  for (std::size_t c = 0; c < cells.size(); ++c) {
    int still = 0, elsewhere = 0;
    for (std::size_t i = 0; i < cells[c].size(); ++i, ++k) {
      const bool found = there[k] && again[k] && cv::norm(back[k] - from[k]) < kThereAndBack;
      const double way = cv::norm(to[k] - from[k]);
      if (found && way < kStill) ++still;
      if (found && way >= kStill) ways.push_back(way), ++elsewhere;
    }
    if (cells[c].empty()) continue;
    ++out.textured;
    rows[c / kCells] = columns[c % kCells] = true;
    out.still += 2 * still >= static_cast<int>(cells[c].size());
    out.elsewhere += 2 * elsewhere > static_cast<int>(cells[c].size());
  }
  out.spread = static_cast<double>(std::min(std::count(rows, rows + kCells, true),
                                            std::count(columns, columns + kCells, true))) /
               kCells;
  if (!ways.empty()) out.moved = median(std::move(ways)) * a.width / first.cols;
  return out;
}

bool CameraStillness::tells() const { return textured >= kFewestCells && spread >= kSpread; }

bool CameraStillness::camera_moved() const {
  return tells() && still < kStillShare * textured && elsewhere > kStillShare * textured;
}

}  // namespace floatstage::matting
