#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/keyer.h"

namespace floatstage {
namespace {

constexpr int kSubject = 128;  // alpha from here on is subject
constexpr int kFaint = 24;     // alpha from here on hangs together with its neighbours

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

// Cuts wires, stands and the like off the subject: what an opening removes and lies further than 2r from what the
// opening keeps. Fingers and hair stay, as they are shorter than that or thicker.
void cut_thin_parts(cv::Mat& core, int radius) {
  cv::Mat thick, near;
  cv::erode(core, thick, disc(radius));
  cv::dilate(thick, near, disc(3 * radius));  // r undoes the erosion, 2r is the reach
  cv::bitwise_and(core, near, core);
}

struct Components {
  cv::Mat labels;  // CV_32S, 0 is outside
  std::vector<int> area;
  int largest = 0;  // a label; 0 when there is none
};

Components components_of(const cv::Mat& binary, int connectivity) {
  Components found;
  const int count = cv::connectedComponents(binary, found.labels, connectivity, CV_32S, cv::CCL_SAUF);
  found.area.assign(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < found.labels.rows; ++y) {
    const int* row = found.labels.ptr<int>(y);
    for (int x = 0; x < found.labels.cols; ++x) ++found.area[static_cast<std::size_t>(row[x])];
  }
  for (int i = 1; i < count; ++i)
    if (found.largest == 0 || found.area[static_cast<std::size_t>(i)] > found.area[static_cast<std::size_t>(found.largest)])
      found.largest = i;
  return found;
}

// For each label: does it stay?
using Kept = std::vector<std::uint8_t>;

void keep_only(cv::Mat& core, const Components& islands, const Kept& kept) {
  for (int y = 0; y < core.rows; ++y) {
    const int* label = islands.labels.ptr<int>(y);
    std::uint8_t* row = core.ptr<std::uint8_t>(y);
    for (int x = 0; x < core.cols; ++x) row[x] = kept[static_cast<std::size_t>(label[x])] ? 255 : 0;
  }
}

// Erases what was dropped with its soft edge, and everything that does not hang together with what was kept.
void erase_the_rest(cv::Mat& alpha, const cv::Mat& kept_core, const cv::Mat& dropped_core) {
  cv::Mat around_kept, around_dropped;
  cv::dilate(kept_core, around_kept, disc(2));
  cv::dilate(dropped_core, around_dropped, disc(2));
  alpha.setTo(0, around_dropped & ~around_kept);
  const cv::Mat faint = alpha >= kFaint;
  const Components parts = components_of(faint, 8);
  Kept touched(parts.area.size(), 0);
  for (int y = 0; y < alpha.rows; ++y) {
    const int* label = parts.labels.ptr<int>(y);
    const std::uint8_t* core = kept_core.ptr<std::uint8_t>(y);
    for (int x = 0; x < alpha.cols; ++x)
      if (core[x]) touched[static_cast<std::size_t>(label[x])] = 1;
  }
  touched[0] = 0;
  for (int y = 0; y < alpha.rows; ++y) {
    const int* label = parts.labels.ptr<int>(y);
    const std::uint8_t* near = around_kept.ptr<std::uint8_t>(y);
    std::uint8_t* row = alpha.ptr<std::uint8_t>(y);
    for (int x = 0; x < alpha.cols; ++x)
      if (!touched[static_cast<std::size_t>(label[x])] && !near[x]) row[x] = 0;
  }
}

// Holes are what is not subject and does not touch the picture's edge.
void fill_holes(cv::Mat& alpha, double largest_hole) {
  const cv::Mat outside = alpha < kSubject;
  const Components gaps = components_of(outside, 4);
  Kept fill(gaps.area.size(), 0);
  for (std::size_t i = 1; i < fill.size(); ++i) fill[i] = gaps.area[i] < largest_hole;
  fill[0] = 0;
  for (int x = 0; x < alpha.cols; ++x)
    fill[static_cast<std::size_t>(gaps.labels.at<int>(0, x))] = fill[static_cast<std::size_t>(gaps.labels.at<int>(alpha.rows - 1, x))] = 0;
  for (int y = 0; y < alpha.rows; ++y)
    fill[static_cast<std::size_t>(gaps.labels.at<int>(y, 0))] = fill[static_cast<std::size_t>(gaps.labels.at<int>(y, alpha.cols - 1))] = 0;
  for (int y = 0; y < alpha.rows; ++y) {
    const int* label = gaps.labels.ptr<int>(y);
    std::uint8_t* row = alpha.ptr<std::uint8_t>(y);
    for (int x = 0; x < alpha.cols; ++x)
      if (fill[static_cast<std::size_t>(label[x])]) row[x] = 255;
  }
}

}  // namespace

Image clean_up(const Image& raw, const CleanupOptions& options) {
  FLOATSTAGE_CHECK(raw.channels == 1 || raw.empty(), "clean_up() takes one channel");
  if (raw.empty()) return raw;
  Image result = raw;
  cv::Mat alpha(result.height, result.width, CV_8U, result.pixels.data());
  if (options.close_radius > 0) {
    cv::Mat closed;
    cv::morphologyEx(alpha, closed, cv::MORPH_CLOSE, disc(options.close_radius));
    closed.copyTo(alpha);
  }
  const cv::Mat subject = alpha >= kSubject;
  cv::Mat core = subject.clone();
  if (options.thin_radius > 0) cut_thin_parts(core, options.thin_radius);
  const Components islands = components_of(core, 8);
  if (islands.largest == 0) {
    alpha.setTo(0);
    return result;
  }
  const double largest = islands.area[static_cast<std::size_t>(islands.largest)];
  Kept kept(islands.area.size(), 0);
  for (std::size_t i = 1; i < kept.size(); ++i)
    kept[i] = options.largest_only ? static_cast<int>(i) == islands.largest
                                   : islands.area[i] >= options.smallest_island * largest;
  keep_only(core, islands, kept);
  erase_the_rest(alpha, core, subject & ~core);
  if (options.smallest_hole > 0) fill_holes(alpha, options.smallest_hole * largest);
  return result;
}

}  // namespace floatstage
