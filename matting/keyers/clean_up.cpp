// Method:  closing, thin attachments, small islands, small holes, in this order
// Paper:   mathematical morphology: J. Serra, "Image analysis and mathematical morphology", 1982
// Differs: sizes are shares of the largest island; soft
//          edges of what stays are kept
// ADR:     0041, 0347

#include "matting/keyers/clean_up.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/bit_clean_up.h"

namespace floatstage::matting {
namespace {

constexpr int kSubject = 128;    // alpha from here on is subject
constexpr int kFaint = 24;       // alpha from here on hangs together with its neighbours
constexpr int kSoftEdge = 2;     // px around the subject that belong to its soft edge
constexpr int kFaintReach = 48;  // px: how far faint hair may stand off; bounds the work

cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

cv::Mat square(int radius) {  // separable, so large radii are cheap
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
}

cv::Rect grown(const cv::Rect& box, int by, const cv::Size& limits) {
  return cv::Rect(box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by) & cv::Rect({0, 0}, limits);
}

// Cuts wires, stands and the like off the subject: what an erosion removes and lies further than 2r from what
// the erosion leaves, grown back. Fingers and hair stay, as they are shorter than that or thicker.
void cut_thin_parts(cv::Mat& core, int radius) {
  cv::Mat thick, near;
  cv::erode(core, thick, disc(radius));
  cv::dilate(thick, near, square(3 * radius));  // r undoes the erosion, 2r is the reach
  cv::bitwise_and(core, near, core);
}

struct Components {
  cv::Mat labels;         // CV_32S, 0 is outside
  std::vector<int> area;  // by label; [0] unused
  std::vector<cv::Rect> box;
  std::size_t largest = 0;  // a label; 0 when there is none
};

Components components_of(const cv::Mat& binary, int connectivity) {
  Components found;
  cv::Mat stats, centroids;
  const int count = cv::connectedComponentsWithStats(binary, found.labels, stats, centroids, connectivity,
                                                     CV_32S, cv::CCL_SAUF);
  found.area.assign(static_cast<std::size_t>(count), 0);
  found.box.resize(static_cast<std::size_t>(count));
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const auto label = static_cast<std::size_t>(i);
    found.area[label] = s[cv::CC_STAT_AREA];
    found.box[label] = {s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]};
    if (found.area[label] > found.area[found.largest]) found.largest = label;
  }
  return found;
}

// By label: 255 for those that are chosen.
using Choice = std::vector<std::uint8_t>;

cv::Mat mask_of(const cv::Mat& labels, const Choice& chosen) {
  cv::Mat mask(labels.size(), CV_8U);
  for (int y = 0; y < labels.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    std::uint8_t* row = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < labels.cols; ++x) row[x] = chosen[static_cast<std::size_t>(label[x])];
  }
  return mask;
}

// Erases what was dropped with its soft edge, and everything that does not hang together with what was kept.
void erase_the_rest(cv::Mat& alpha, const cv::Mat& kept, const cv::Mat& dropped) {
  cv::Mat around_kept, around_dropped;
  cv::dilate(kept, around_kept, square(kSoftEdge));
  cv::dilate(dropped, around_dropped, square(kSoftEdge));
  alpha.setTo(0, around_dropped & ~around_kept);
  const Components parts = components_of(alpha >= kFaint, 8);
  Choice touched(parts.area.size(), 0);
  for (int y = 0; y < alpha.rows; ++y) {
    const int* label = parts.labels.ptr<int>(y);
    const std::uint8_t* core = kept.ptr<std::uint8_t>(y);
    for (int x = 0; x < alpha.cols; ++x)
      if (core[x]) touched[static_cast<std::size_t>(label[x])] = 255;
  }
  touched[0] = 0;
  alpha.setTo(0, ~(mask_of(parts.labels, touched) | around_kept));
}

// A hole is what is not subject and does not reach the edge of the subject's bounding box.
void fill_holes(cv::Mat& alpha, double largest_hole) {
  const Components gaps = components_of(alpha < kSubject, 4);
  const cv::Rect inside(1, 1, alpha.cols - 2, alpha.rows - 2);
  Choice fill(gaps.area.size(), 0);
  bool any = false;
  for (std::size_t i = 1; i < fill.size(); ++i) {
    if (gaps.area[i] >= largest_hole || (gaps.box[i] & inside) != gaps.box[i]) continue;
    fill[i] = 255;
    any = true;
  }
  if (any) alpha.setTo(255, mask_of(gaps.labels, fill));
}

void close_gaps(cv::Mat& alpha, int radius) {
  cv::Mat closed;
  cv::morphologyEx(alpha, closed, cv::MORPH_CLOSE, disc(radius));
  closed.copyTo(alpha);
}

// Leaves of a row what is `kept`, and fills what is `filled`.
void apply(const std::uint64_t* kept, const std::uint64_t* filled, int count, std::uint8_t* row) {
  for (int x = 0; x < count; x += 64, ++kept, ++filled) {
    const int here = std::min(64, count - x);
    const std::uint64_t whole = ~std::uint64_t{0} >> (64 - here), gone = ~(*kept | *filled) & whole;
    if (gone == whole) {
      std::memset(row + x, 0, static_cast<std::size_t>(here));
      continue;
    }
    set_row(&gone, here, 0, row + x);
    set_row(filled, here, 255, row + x);
  }
}

}  // namespace

Image clean_up_by_labels(const Image& raw, const CleanupOptions& options) {
  if (raw.empty()) return raw;
  Image result = raw;
  cv::Mat whole(result.height, result.width, CV_8U, result.pixels.data());

  // Work happens in boxes around what is there; a closing acts up to twice its radius away.
  const cv::Rect box = grown(cv::boundingRect(whole), 2 * options.close_radius + 1, whole.size());
  if (box.empty()) return result;
  cv::Mat alpha = whole(box);
  if (options.close_radius > 0) close_gaps(alpha, options.close_radius);

  const cv::Mat subject = alpha >= kSubject;
  cv::Mat core = subject.clone();
  if (options.thin_radius > 0) cut_thin_parts(core, options.thin_radius);
  const Components islands = components_of(core, 8);
  if (islands.largest == 0) {
    alpha.setTo(0);
    return result;
  }
  const double largest = islands.area[islands.largest];
  Choice kept(islands.area.size(), 0);
  cv::Rect kept_box;
  for (std::size_t i = 1; i < kept.size(); ++i) {
    if (options.largest_only ? i != islands.largest : islands.area[i] < options.smallest_island * largest)
      continue;
    kept[i] = 255;
    kept_box |= islands.box[i];
  }

  const cv::Rect near = grown(kept_box, kFaintReach, alpha.size());
  cv::Mat near_alpha = alpha(near).clone();
  const cv::Mat near_core = mask_of(islands.labels(near), kept);
  erase_the_rest(near_alpha, near_core, subject(near) & ~near_core);
  whole.setTo(0);
  near_alpha.copyTo(alpha(near));
  if (options.smallest_hole > 0) {
    cv::Mat there = alpha(kept_box);
    fill_holes(there, options.smallest_hole * largest);
  }
  return result;
}

Image clean_up(const Image& raw, const CleanupOptions& options) {
  FLOATSTAGE_CHECK(raw.channels == 1 || raw.empty(), "clean_up() takes one channel");
  CleanupOptions closed = options;
  closed.close_radius = 0;
  if (!BitCleanUp::can(closed)) return clean_up_by_labels(raw, options);
  BitBox box = bounding_box(raw);
  Image result = raw;
  if (box.empty()) return result;
  const int by = 2 * options.close_radius + 1;
  box = {std::max(box.x0 - by, 0), std::max(box.y0 - by, 0), std::min(box.x1 + by, raw.width),
         std::min(box.y1 + by, raw.height)};
  if (options.close_radius > 0) {
    cv::Mat whole(result.height, result.width, CV_8U, result.pixels.data());
    cv::Mat alpha = whole(cv::Rect(box.x0, box.y0, box.x1 - box.x0, box.y1 - box.y0));
    close_gaps(alpha, options.close_radius);
  }
  BitCleanUp cleaner;
  BitRows subject, faint;
  bits_of(result, box, kSubject, subject);
  bits_of(result, box, kFaint, faint);
  cleaner.run(closed, subject, faint);
  for (int y = box.y0; y < box.y1; ++y)
    apply(cleaner.kept().row(y - box.y0), cleaner.filled().row(y - box.y0), subject.width(),
          result.at(box.x0, y));
  return result;
}

}  // namespace floatstage::matting
