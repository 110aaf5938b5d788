// Method:  opacity along the outline between the field's colour and the near inside
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996, eq. 1, along one axis; F. C. Crow,
//          "Summed-area tables for texture mapping", 1984, for the means
// Differs: square roots of colours; one backing and the near inside in the place of a second backing
// ADR:     0170, 0347

#include <algorithm>
#include <array>

#include <opencv2/core.hpp>

#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/field_rows.h"

namespace floatstage::matting {
namespace {

// Sums of the colours of chosen pixels in windows around pixels whose rows come one after the other. Whole
// numbers, so in any order the same.
class ChosenColors {
 public:
  // Red and green; blue and how many pixels: one in the lower half of a word, one in the upper. Differences
  // of sums are right where they fit, whatever the sums overflow.
  using Sums = std::array<std::uint64_t, 2>;
  ChosenColors(const Image& picture, const BitBox& box, const BitRows& chosen, int reach)
      : picture_(picture),
        box_(box),
        chosen_(chosen),
        height_(box.y1 - box.y0),
        width_(box.x1 - box.x0),
        reach_(reach),
        room_(static_cast<std::size_t>(width_) + 1),
        ring_(static_cast<std::size_t>(2 * reach + 2) * room_) {}

  // Before around() is asked of a row, which may be no further up than the last.
  void go_to(int y) {
    for (const int end = std::min(y + reach_ + 1, height_); rows_ < end; ++rows_) add_row();
  }
  Sums around(int x, int y, int radius) const {
    const int x0 = std::max(x - radius, 0), x1 = std::min(x + radius + 1, width_);
    const Sums *top = row(std::max(y - radius, 0)), *bottom = row(std::min(y + radius + 1, height_));
    Sums sums;
    for (std::size_t k = 0; k < 2; ++k) sums[k] = bottom[x1][k] - bottom[x0][k] - top[x1][k] + top[x0][k];
    return sums;
  }

 private:
  Sums* row(int y) { return ring_.data() + static_cast<std::size_t>(y % (2 * reach_ + 2)) * room_; }
  const Sums* row(int y) const {
    return ring_.data() + static_cast<std::size_t>(y % (2 * reach_ + 2)) * room_;
  }
  void add_row() {
    const std::uint64_t* bits = chosen_.row(rows_);
    const std::uint8_t* p = picture_.at(box_.x0, box_.y0 + rows_);
    const Sums* above = row(rows_);
    Sums *out = row(rows_ + 1), sums = {};
    out[0] = {};
    for (int x = 0; x < width_; ++x, p += 3) {
      const std::uint64_t all = 0U - (bits[x / 64] >> (x % 64) & 1U);
      sums[0] += (p[0] | static_cast<std::uint64_t>(p[1]) << 32) & all;
      sums[1] += (p[2] | std::uint64_t{1} << 32) & all;
      for (std::size_t k = 0; k < 2; ++k) out[x + 1][k] = above[x + 1][k] + sums[k];
    }
  }

  const Image& picture_;
  BitBox box_;
  const BitRows& chosen_;
  int height_, width_, reach_, rows_ = 0;
  std::size_t room_;
  std::vector<Sums> ring_;  // row y: of what lies above it
};

cv::Vec3f roots(const cv::Vec3f& c) {
  return {std::sqrt(std::max(c[0], 0.0f)), std::sqrt(std::max(c[1], 0.0f)), std::sqrt(std::max(c[2], 0.0f))};
}

}  // namespace

void BackingField::solve_edges(const Image& picture, Image& alpha) const {
  solve_edges(picture, alpha, nullptr, alpha);
}

void BackingField::solve_edges(const Image& picture, const Image& key, const BitRows& here,
                               Image& alpha) const {
  solve_edges(picture, key, &here, alpha);
}

void BackingField::solve_edges(const Image& picture, const Image& key, const BitRows* here,
                               Image& alpha) const {
  const int band = cell(picture.width), near = band + band / 2, far = 2 * band;
  BitBox box = bounding_box(key);
  if (box.empty()) return;
  const int by = 4 * band + 1;
  box = {std::max(box.x0 - by, 0), std::max(box.y0 - by, 0), std::min(box.x1 + by, alpha.width),
         std::min(box.y1 + by, alpha.height)};
  BitMorphology morphology;
  BitRows subject, inside, asked;
  bits_of(key, box, 128, subject);
  erode_square(morphology, subject, band, inside);
  dilate_square(morphology, subject, band, asked);
  for (std::size_t i = 0; i < asked.all().size(); ++i) asked.all()[i] &= ~inside.all()[i];

  // The inside that is near an outline's pixel; further in only where that is thin.
  ChosenColors colors(picture, box, inside, far);
  const auto solve = [&](int x, int y) {
    const int px = box.x0 + x, py = box.y0 + y;
    ChosenColors::Sums sums = colors.around(x, y, near);
    if (sums[1] >> 32 < 3) sums = colors.around(x, y, far);
    const auto upper = [](std::uint64_t two) { return static_cast<float>(two >> 32); };
    const auto lower = [](std::uint64_t two) { return static_cast<float>(two & 0xffffffff); };
    const float count = upper(sums[1]);
    if (count == 0) return;
    const auto col = static_cast<std::size_t>(px) * static_cast<std::size_t>(cols_) /
                     static_cast<std::size_t>(picture.width),
               row = static_cast<std::size_t>(py) * static_cast<std::size_t>(rows_) /
                     static_cast<std::size_t>(picture.height);
    if (known(col, row) == 0) return;
    float terms[FieldRow::kTerms];
    const float* planes = this->terms(Scale::Pixel, static_cast<int>(row)) + col;
    for (std::size_t k = 0; k < FieldRow::kTerms; ++k) terms[k] = planes[k * stride()];
    const cv::Vec3f backing(terms[0], terms[1], terms[2]);
    const cv::Vec3f sum(lower(sums[0]), upper(sums[0]), lower(sums[1]));
    const cv::Vec3f contrast = sum / count - backing;
    if (whitened_length(terms + 3, contrast[0], contrast[1], contrast[2]) < 2 * sigmas_) return;
    const cv::Vec3f low = roots(backing), span = roots(backing + contrast) - low;
    const std::uint8_t* p = picture.at(px, py);
    const cv::Vec3f color(p[0], p[1], p[2]);
    const float a = (roots(color) - low).dot(span) / std::max(span.dot(span), 1e-6f);
    *alpha.at(px, py) = static_cast<std::uint8_t>(std::clamp(255 * a + 0.5f, 0.0f, 255.0f));
  };
  for (int y = 0; y < asked.height(); ++y)
    for_each_bit(asked, y, [&](int x) {
      if (here != nullptr && !here->at(box.x0 + x, box.y0 + y)) return;
      colors.go_to(y);
      solve(x, y);
    });
}

}  // namespace floatstage::matting
