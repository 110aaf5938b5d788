// Method:  what is no cloth at the rim, as a backing of its own; then the colours of either side
// Paper:   see matting/keyers/backing_field.h and second_look.h
// ADR:     0170, 0347

#include "matting/keyers/walls.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/rim_check.h"
#include "matting/keyers/second_look.h"

namespace floatstage::matting {
namespace {

constexpr double kOtherShare = 0.1;  // of the rim that is no cloth: there are other backings than cloth

// Walls and curtains are large and evenly lit.
constexpr FieldOptions kWalls{.sigmas = 3.5, .reach = 0.1};

cv::Mat in_place(const Image& mask) {
  return cv::Mat(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.pixels.data()));
}

// Along the rim: what is no cloth and hangs together with an upper corner (255), all else that is no cloth
// (128).
cv::Mat parts_of_rim(const Image& cloth, int rim) {
  cv::Mat parts = in_place(cloth) >= 128;
  parts(cv::Rect(rim, rim, cloth.width - 2 * rim, cloth.height - 2 * rim)).setTo(0);
  // A pole that is painted like the cloth is narrower than the rim, and parts no wall.
  cv::Mat bridged, labels;
  cv::dilate(parts, bridged, cv::getStructuringElement(cv::MORPH_RECT, {rim | 1, rim | 1}));
  const int count = cv::connectedComponents(bridged, labels, 8, CV_32S);
  std::vector<std::uint8_t> wall(static_cast<std::size_t>(count), 0);
  for (const int x0 : {0, cloth.width - rim})
    for (int y = 0; y < rim; ++y)
      for (int x = x0; x < x0 + rim; ++x)
        if (parts.at<std::uint8_t>(y, x)) wall[static_cast<std::size_t>(labels.at<int>(y, x))] = 1;
  for (int y = 0; y < parts.rows; ++y)
    for (int x = 0; x < parts.cols; ++x)
      if (parts.at<std::uint8_t>(y, x) && !wall[static_cast<std::size_t>(labels.at<int>(y, x))])
        parts.at<std::uint8_t>(y, x) = 128;
  return parts;
}

template <class What>
void each_pixel(const Image& with, Image& alpha, const What& what) {
  const std::uint8_t* from = with.pixels.data();
  std::uint8_t* to = alpha.pixels.data();
  for (std::size_t i = 0, count = alpha.pixels.size(); i < count; ++i) to[i] = what(from[i], to[i]);
}

}  // namespace

std::optional<Walls> Walls::learn(const std::vector<Image>& samples, const std::vector<Image>& cloth) {
  std::vector<Image> left_out;
  double rim_pixels = 0, wall_pixels = 0;
  // A floor reaches both lower corners; cloth that does not may be a thing in a room.
  bool left = false, right = false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int w = cloth[i].width, h = cloth[i].height, rim = rim_width(w, h);
    if (rim == 0 || 2 * rim >= std::min(w, h)) return std::nullopt;
    const cv::Mat parts = parts_of_rim(cloth[i], rim);
    rim_pixels += static_cast<double>(w) * h - static_cast<double>(w - 2 * rim) * (h - 2 * rim);
    wall_pixels += cv::countNonZero(parts == 255);
    left = left || parts.at<std::uint8_t>(h - 1, 0) == 0;
    right = right || parts.at<std::uint8_t>(h - 1, w - 1) == 0;
    Image mask(w, h, 1);
    in_place(mask).setTo(255, (in_place(cloth[i]) < 128) | (parts == 128));
    left_out.push_back(std::move(mask));
  }
  if (!left || !right || wall_pixels == 0 || wall_pixels < kOtherShare * rim_pixels) return std::nullopt;
  std::optional<BackingField> field = learn_field(samples, left_out, kWalls);
  if (!field) return std::nullopt;
  return Walls(std::move(*field));
}

Image Walls::key(const Image& picture, const Image& cloth, const CleanupOptions& cleanup) const {
  Image alpha = field_.key(picture);
  each_pixel(cloth, alpha, [](std::uint8_t c, std::uint8_t a) { return std::min(a, c); });
  alpha = clean_up(second_look(picture, clean_up(alpha, cleanup)), cleanup);
  // Holes before cloth are the cloth key's to judge: others are full now, or as they were.
  Image filled = alpha;
  field_.fill_holes(picture, filled);
  each_pixel(cloth, filled, [](std::uint8_t c, std::uint8_t f) { return c >= 128 ? f : std::uint8_t{0}; });
  each_pixel(filled, alpha, [](std::uint8_t f, std::uint8_t a) { return std::max(f, a); });
  return alpha;
}

void Walls::solve_edges(const Image& picture, const Image& cloth, const Image& key, Image& alpha) const {
  const BitBox whole{0, 0, key.width, key.height};
  BitMorphology morphology;
  BitRows subject, wall, near;
  bits_of(key, whole, 128, subject);
  bits_of(cloth, whole, 128, wall);
  for (std::size_t i = 0; i < wall.all().size(); ++i) wall.all()[i] &= ~subject.all()[i];
  dilate_square(morphology, wall, field_.cell(key.width), near);
  for (int y = 0; y < key.height; ++y) copy_row(near.row(y), key.width, key.at(0, y), alpha.at(0, y));
  field_.solve_edges(picture, key, near, alpha);
}

}  // namespace floatstage::matting
