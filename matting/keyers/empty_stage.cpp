#include "matting/keyers/empty_stage.h"

#include <algorithm>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/image_mat.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {
namespace {

constexpr int kFaint = 24;   // alpha from which clean-up counts a pixel to what it hangs together with
constexpr int kSmall = 240;  // px a side below which five pixels are as wide as an arm
constexpr int kEdge = 2;     // px: lenses and demosaicing spread an edge as far

// Before cloth the colour tells shadows. Here only what no shadow can be counts: darker, brighter, or
// coloured.
constexpr PlateKeyOptions kSolid{.darkest_shadow = 0.3, .brightest_reflex = 1.4};
constexpr CleanupOptions kWhole{.close_radius = 1, .smallest_island = 0.005, .smallest_hole = 0.002};

// How far from its outline a subject's opacity is no key's to tell: motion and hair grow with the picture.
int rim_of(const Image& picture) { return kEdge + std::max(picture.width, picture.height) / 160; }

}  // namespace

EmptyStage::EmptyStage(Plate plate, const Image& key)
    : plate_(std::move(plate)), core_(key.width, key.height, 1) {
  FLOATSTAGE_CHECK(key.width == plate_.color.width && key.height == plate_.color.height && key.channels == 1,
                   "the key of a plate is of its size");
  for (std::size_t p = 0; p < core_.pixels.size(); ++p) core_.pixels[p] = key.pixels[p] >= kFaint ? 255 : 0;
  fixtures_ = grown(core_, kEdge);
}

bool EmptyStage::take_out_fixtures(const Image& picture, double smallest_island, Image& key) const {
  if (picture.width != fixtures_.width || picture.height != fixtures_.height || key.width != picture.width ||
      key.height != picture.height)
    return false;
  const Image subject = where_is(classify(plate_, picture), PlateClass::Subject);
  bool changed = false;
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    if (key.pixels[p] == 0 || fixtures_.pixels[p] == 0 || subject.pixels[p] != 0) continue;
    key.pixels[p] = 0;
    changed = true;
  }
  if (changed) key = clean_up(key, {.smallest_island = smallest_island, .smallest_hole = 0});
  return true;
}

double EmptyStage::fixtures_shown(const Image& picture) const {
  const Image subject = where_is(classify(plate_, picture), PlateClass::Subject);
  std::size_t all = 0, shown = 0;
  for (std::size_t p = 0; p < core_.pixels.size(); ++p) {
    if (core_.pixels[p] == 0) continue;
    ++all;
    shown += subject.pixels[p] == 0;
  }
  return all > 0 ? static_cast<double>(shown) / static_cast<double>(all) : 1;
}

Image EmptyStage::solid(const Image& picture) const {
  return clean_up(where_is(classify(plate_, picture, kSolid), PlateClass::Subject), kWhole);
}

Image EmptyStage::inside(const Image& mask) {
  Image out(mask.width, mask.height, 1);
  const int rim = rim_of(mask);
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, cv::Size(2 * rim + 1, 2 * rim + 1));
  cv::Mat to = as_mat(out);
  cv::erode(as_mat(mask), to, square);
  for (std::uint8_t& p : out.pixels) p = p >= 128 ? 255 : 0;
  return out;
}

Image EmptyStage::not_outlines(const Image& part, const Image& whole) {
  const cv::Mat five = cv::getStructuringElement(cv::MORPH_RECT, cv::Size(5, 5));
  cv::Mat thick, surrounded;
  cv::morphologyEx(as_mat(part), thick, cv::MORPH_OPEN, five);
  cv::erode(as_mat(whole), surrounded, five);
  if (std::max(part.width, part.height) < kSmall) surrounded.setTo(0);
  Image out(part.width, part.height, 1);
  cv::Mat to = as_mat(out);
  cv::max(thick, cv::min(as_mat(part), surrounded), to);
  return out;
}

}  // namespace floatstage::matting
