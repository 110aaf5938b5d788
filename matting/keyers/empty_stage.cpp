#include "matting/keyers/empty_stage.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/image_mat.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {
namespace {

constexpr int kSmall = 240;  // px a side below which five pixels are as wide as an arm
constexpr int kEdge = 2;     // px: lenses and demosaicing spread an edge as far

// Before cloth the colour tells shadows. Here only what no shadow can be counts: darker, brighter, or
// coloured.
constexpr PlateKeyOptions kSolid{.darkest_shadow = 0.3, .brightest_reflex = 1.4};
constexpr CleanupOptions kWhole{.close_radius = 1, .smallest_island = 0.005, .smallest_hole = 0.002};

constexpr CleanupOptions kAsItIs{.smallest_island = 0, .smallest_hole = 0};
constexpr double kOutline = 2.0 / 480;  // of the longer side: half of what is thicker than an outline

// 255 where a picture is half opaque against the plate.
Image subject_of(const PlateMeasure& measure, const Image& picture) {
  Image mask(picture.width, picture.height, 1);
  for (int y = 0; y < picture.height; ++y)
    measure.opacities(picture.at(0, y), 0, y, picture.width, mask.at(0, y));
  for (std::uint8_t& p : mask.pixels) p = p >= kSubjectAlpha ? 255 : 0;
  return mask;
}

// Of a key from which something was taken, goes what hangs together with it and is no subject's part by its
// size: its edges.
void drop_remains(const Image& around_gone, double smallest_island, Image& key) {
  cv::Mat alpha = as_mat(key), labels, stats, centroids;
  const int count =
      cv::connectedComponentsWithStats(alpha > 0, labels, stats, centroids, 8, CV_32S, cv::CCL_SAUF);
  std::vector<int> area(static_cast<std::size_t>(count), 0);
  std::vector<bool> touched(area.size(), false);
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x) {
      const auto label = static_cast<std::size_t>(labels.at<int>(y, x));
      area[label] += *key.at(x, y) >= kSubjectAlpha;
      if (*around_gone.at(x, y) != 0) touched[label] = true;
    }
  area[0] = 0;
  const double least = smallest_island * *std::max_element(area.begin(), area.end());
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x) {
      const auto label = static_cast<std::size_t>(labels.at<int>(y, x));
      if (touched[label] && (area[label] < least || area[label] == 0)) *key.at(x, y) = 0;
    }
}

cv::Mat square(int radius) {
  return cv::getStructuringElement(cv::MORPH_RECT, cv::Size(2 * radius + 1, 2 * radius + 1));
}

// Of `part`, what is thicker than an outline, and what `whole` surrounds `reach` px far.
Image thick_or_within(const Image& part, const Image& whole, int reach) {
  cv::Mat thick, surrounded;
  cv::morphologyEx(as_mat(part), thick, cv::MORPH_OPEN, square(EmptyStage::outline_radius(part)));
  cv::erode(as_mat(whole), surrounded, square(reach));
  if (!EmptyStage::tells_stripes(part)) surrounded.setTo(0);
  Image out(part.width, part.height, 1);
  cv::Mat to = as_mat(out);
  cv::max(thick, cv::min(as_mat(part), surrounded), to);
  return out;
}

}  // namespace

std::optional<EmptyStage> EmptyStage::seen_by(const Keyer& keyer, Plate plate) {
  // What the keyer does not clean away of the empty stage it need not clean away beside a subject either.
  const Result<std::unique_ptr<Keyer>> raw = make_keyer(keyer.spec(), {plate.color}, kAsItIs);
  if (!raw) return std::nullopt;
  const Result<Matte> key = (*raw)->key(make_frame({}, plate.color));
  if (!key) return std::nullopt;
  return EmptyStage(std::move(plate), to_image(*key), keyer.cleanup().smallest_island);
}

EmptyStage::EmptyStage(Plate plate, const Image& key, double smallest_island)
    : alike_(measure_of(plate, {})),
      no_shadow_(measure_of(plate, kSolid)),
      smallest_island_(smallest_island),
      core_(key.width, key.height, 1) {
  FLOATSTAGE_CHECK(alike_.fits(key.width, key.height) && key.channels == 1,
                   "the key of a plate is of its size");
  for (std::size_t p = 0; p < core_.pixels.size(); ++p)
    core_.pixels[p] = key.pixels[p] >= kFaintAlpha ? 255 : 0;
  fixtures_ = grown(core_, kEdge);
}

bool EmptyStage::take_out_fixtures(const Image& picture, Image& key) const {
  if (!alike_.fits(picture.width, picture.height) || key.width != picture.width ||
      key.height != picture.height)
    return false;
  const Image subject = subject_of(alike_, picture);
  Image gone(key.width, key.height, 1);
  bool changed = false;
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    if (key.pixels[p] == 0 || fixtures_.pixels[p] == 0 || subject.pixels[p] != 0) continue;
    key.pixels[p] = 0;
    gone.pixels[p] = 255;
    changed = true;
  }
  if (changed) drop_remains(grown(gone, 1), smallest_island_, key);
  return true;
}

bool EmptyStage::correct(const Image& picture, Image& key) const {
  if (!take_out_fixtures(picture, key)) return false;
  const Image seen = subject_of(no_shadow_, picture);
  Image more = clean_up(seen, kWhole);
  if (!fits(more, key)) return false;
  more = touching(more, key);
  // What the key lacks: parts that are thicker than an outline, and stripes and folds, which are seen all
  // around. Between strands of hair the stage is.
  Image lacks = more, firm = more;
  for (std::size_t p = 0; p < lacks.pixels.size(); ++p) {
    if (key.pixels[p] >= kSubjectAlpha) lacks.pixels[p] = 0;
    firm.pixels[p] &= seen.pixels[p];
  }
  lacks = thick_or_within(lacks, firm, outline_radius(lacks) - 1);
  const Image within = inside(more);
  for (std::size_t p = 0; p < key.pixels.size(); ++p)
    key.pixels[p] = std::max({key.pixels[p], lacks.pixels[p], within.pixels[p]});
  return true;
}

double EmptyStage::fixtures_shown(const Image& picture) const {
  const Image subject = subject_of(alike_, picture);
  std::size_t all = 0, shown = 0;
  for (std::size_t p = 0; p < core_.pixels.size(); ++p) {
    if (core_.pixels[p] == 0) continue;
    ++all;
    shown += subject.pixels[p] == 0;
  }
  return all > 0 ? static_cast<double>(shown) / static_cast<double>(all) : 1;
}

Image EmptyStage::solid(const Image& picture) const {
  return clean_up(subject_of(no_shadow_, picture), kWhole);
}

bool EmptyStage::fits(const Image& solid, const Image& key) {
  std::size_t alone = 0, keyed = 0;
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    keyed += key.pixels[p] >= kSubjectAlpha;
    alone += key.pixels[p] < kSubjectAlpha && solid.pixels[p] >= kSubjectAlpha;
  }
  return alone <= keyed;
}

Image EmptyStage::touching(const Image& more, const Image& key) {
  Image found(key.width, key.height, 1);
  std::vector<std::pair<int, int>> open;
  const auto visit = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= key.width || y >= key.height || *found.at(x, y) != 0 ||
        *more.at(x, y) < kSubjectAlpha)
      return;
    *found.at(x, y) = 255;
    open.emplace_back(x, y);
  };
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x)
      if (*key.at(x, y) >= kSubjectAlpha) visit(x, y);
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u) visit(u, v);
  }
  return found;
}

const CleanupOptions& EmptyStage::solid_clean_up() { return kWhole; }

// How far from its outline a subject's opacity is no key's to tell: motion and hair grow with the picture.
int EmptyStage::rim(const Image& picture) { return kEdge + std::max(picture.width, picture.height) / 160; }

int EmptyStage::outline_radius(const Image& picture) {
  return std::max(2, static_cast<int>(std::lround(kOutline * std::max(picture.width, picture.height))));
}

bool EmptyStage::tells_stripes(const Image& picture) {
  return std::max(picture.width, picture.height) >= kSmall;
}

Image EmptyStage::inside(const Image& mask) {
  Image out(mask.width, mask.height, 1);
  cv::Mat to = as_mat(out);
  cv::erode(as_mat(mask), to, square(rim(mask)));
  for (std::uint8_t& p : out.pixels) p = p >= kSubjectAlpha ? 255 : 0;
  return out;
}

Image EmptyStage::not_outlines(const Image& part, const Image& whole) {
  return thick_or_within(part, whole, outline_radius(part));
}

}  // namespace floatstage::matting
