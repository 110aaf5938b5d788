#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "calib/board_detection.h"

namespace floatstage::calib {
namespace {

struct Blob {
  cv::Point2f at;
  float diameter = 0;  // px
};

// The centroid of the light above the surroundings, and how wide a disc of that area is.
std::optional<Blob> measure(const cv::Mat& grey, const cv::Rect& box) {
  const int around = std::max(3, box.width / 4);
  const cv::Rect window =
      cv::Rect(box.x - around, box.y - around, box.width + 2 * around, box.height + 2 * around);
  if ((window & cv::Rect(0, 0, grey.cols, grey.rows)) != window)
    return std::nullopt;  // cut off: its centroid would be wrong
  const cv::Mat part = grey(window);
  double rim = 0;
  for (int x = 0; x < part.cols; ++x)
    rim += part.at<std::uint8_t>(0, x) + part.at<std::uint8_t>(part.rows - 1, x);
  for (int y = 1; y < part.rows - 1; ++y)
    rim += part.at<std::uint8_t>(y, 0) + part.at<std::uint8_t>(y, part.cols - 1);
  rim /= 2 * (part.cols + part.rows) - 4;
  double peak = 0, sum = 0, sx = 0, sy = 0;
  for (int y = 0; y < part.rows; ++y) {
    for (int x = 0; x < part.cols; ++x) {
      // What is barely brighter than the surroundings is noise; it would pull the centroid to the window's
      // middle.
      const double light = part.at<std::uint8_t>(y, x) - rim - 12;
      if (light <= 0) continue;
      sum += light, sx += light * x, sy += light * y;
      peak = std::max(peak, light);
    }
  }
  if (peak < 30) return std::nullopt;
  Blob blob;
  blob.at = {static_cast<float>(window.x + sx / sum), static_cast<float>(window.y + sy / sum)};
  blob.diameter = static_cast<float>(2 * std::sqrt(sum / peak / CV_PI));
  return blob;
}

std::vector<Blob> bright_blobs(const cv::Mat& grey) {
  constexpr std::size_t kMost = 24;
  std::array<int, 256> counts{};
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) ++counts[grey.at<std::uint8_t>(y, x)];
  int median = 0;
  for (long long below = 0; median < 255 && 2 * (below += counts[static_cast<std::size_t>(median)]) <
                                                static_cast<long long>(grey.total());)
    ++median;
  int brightest = 255;
  while (brightest > 0 && counts[static_cast<std::size_t>(brightest)] == 0) --brightest;
  std::vector<Blob> blobs;
  if (brightest - median < 40) return blobs;
  cv::Mat bright, labels, facts, centers;
  cv::threshold(grey, bright, median + 0.5 * (brightest - median), 255, cv::THRESH_BINARY);
  const int count = cv::connectedComponentsWithStats(bright, labels, facts, centers, 8, CV_32S);
  std::vector<std::pair<int, cv::Rect>> round;
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(facts.at<int>(i, cv::CC_STAT_LEFT), facts.at<int>(i, cv::CC_STAT_TOP),
                       facts.at<int>(i, cv::CC_STAT_WIDTH), facts.at<int>(i, cv::CC_STAT_HEIGHT));
    const int area = facts.at<int>(i, cv::CC_STAT_AREA);
    const double fill = static_cast<double>(area) / box.area(),
                 shape = static_cast<double>(box.width) / box.height;
    if (area < 5 || 4 * box.width > std::max(grey.cols, grey.rows) || shape < 0.6 || shape > 1.67 ||
        (area > 40 && (fill < 0.6 || fill > 0.95)))
      continue;
    round.emplace_back(area, box);
  }
  std::stable_sort(round.begin(), round.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  if (round.size() > kMost) round.resize(kMost);
  for (const auto& [area, box] : round)
    if (const std::optional<Blob> blob = measure(grey, box)) blobs.push_back(*blob);
  return blobs;
}

// How badly these blobs fit the wand; absent when they cannot be it. A tilted wand looks shorter, never
// longer; near parts look larger by a little.
std::optional<double> misfit(const Wand& wand, const std::vector<const Blob*>& blobs) {
  const cv::Point2f span = blobs.back()->at - blobs.front()->at;
  const double length = std::hypot(span.x, span.y);
  double smallest = 1e9, largest = 0;
  for (const Blob* b : blobs)
    smallest = std::min(smallest, static_cast<double>(b->diameter)),
    largest = std::max(largest, static_cast<double>(b->diameter));
  const double expected =
      wand.ball / wand.positions.back() * length;  // px: a ball, were the wand upright to the view
  if (length < 8 || largest > 1.8 * smallest + 1 || largest < 0.7 * expected - 1 ||
      smallest > 6 * expected + 3)
    return std::nullopt;
  double cost = std::abs(std::log(largest / std::max(smallest, 0.5)));
  if (blobs.size() == 2) return cost + std::max(0.0, std::log(smallest / std::max(expected, 0.5)));
  const cv::Point2f way = blobs[1]->at - blobs[0]->at;
  const double along = (way.x * span.x + way.y * span.y) / (length * length),
               beside = (way.x * span.y - way.y * span.x) / (length * length);
  if (std::abs(beside) > 0.02 + 1.5 / length || along <= 0.02 || along >= 0.98) return std::nullopt;
  const double ratio = along / (1 - along),
               truth = wand.positions[1] / (wand.positions[2] - wand.positions[1]);
  const double off = std::abs(std::log(ratio / truth));
  if (off > std::log(1.4)) return std::nullopt;
  return cost + 2 * off + 30 * std::abs(beside);
}

BoardSearch find_balls(const cv::Mat& grey, const Wand& wand) {
  BoardSearch search;
  const std::vector<Blob> blobs = bright_blobs(grey);
  std::vector<const Blob*> best;
  double least = 1e9;
  auto consider = [&](const std::vector<const Blob*>& order) {
    const std::optional<double> cost = misfit(wand, order);
    if (cost && *cost < least) least = *cost, best = order;
  };
  for (const Blob& a : blobs) {
    for (const Blob& b : blobs) {
      if (&a == &b) continue;
      if (wand.positions.size() == 2) {
        if (a.at.x < b.at.x) consider({&a, &b});  // which end is which cannot be told: the left one first
        continue;
      }
      for (const Blob& c : blobs)
        if (&c != &a && &c != &b) consider({&a, &b, &c});
    }
  }
  for (std::size_t i = 0; i < best.size(); ++i) search.points.push_back({static_cast<int>(i), best[i]->at});
  return search;
}

// Where a tag's diagonals cross is its centre, whatever the perspective.
std::optional<cv::Point2f> crossing(const std::array<cv::Point2f, 4>& q) {
  const cv::Point2f a = q[2] - q[0], b = q[3] - q[1], d = q[1] - q[0];
  const float det = a.x * b.y - a.y * b.x;
  if (std::abs(det) < 1e-3f) return std::nullopt;
  return q[0] + a * ((d.x * b.y - d.y * b.x) / det);
}

BoardSearch find_tags(const cv::Mat& grey, const Wand& wand) {
  BoardSearch search;
  search.seen = find_markers(grey, wand.dictionary, 1, {.windows = {13, 29}});
  for (const SeenMarker& m : search.seen.markers) {
    const int number = m.id - wand.first_tag;
    if (number < 0 || number >= static_cast<int>(wand.positions.size())) continue;
    std::vector<cv::Point2f> corners(m.corners.begin(), m.corners.end());
    const int half = std::clamp(static_cast<int>(m.side() / 10), 2, 6);
    const bool inner = std::all_of(corners.begin(), corners.end(), [&](cv::Point2f c) {
      return c.x > half + 2 && c.y > half + 2 && c.x < grey.cols - half - 3 && c.y < grey.rows - half - 3;
    });
    if (!inner) continue;
    cv::cornerSubPix(grey, corners, {half, half}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 0.001});
    if (const auto center = crossing({corners[0], corners[1], corners[2], corners[3]}))
      search.points.push_back({number, *center});
    search.consistent.push_back(m);
  }
  std::sort(search.points.begin(), search.points.end(),
            [](const FoundPoint& a, const FoundPoint& b) { return a.id < b.id; });
  return search;
}

}  // namespace

BoardSearch find_wand(const cv::Mat& grey, const Wand& wand) {
  return wand.ball > 0 ? find_balls(grey, wand) : find_tags(grey, wand);
}

}  // namespace floatstage::calib
