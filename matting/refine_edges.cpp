// Method:  the opacity of mixed pixels from a measure that is
//          linear in the subject's share
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996, eq. 1, along one axis
// Differs: both ends of the axis are means over what is near: no second backing is needed
// ADR:     0043, 0347

#include "matting/refine_edges.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "matting/keyers/alpha_bits.h"

namespace floatstage::matting {
namespace {

constexpr int kSubject = 128, kFaint = 24;  // alpha: subject; possibly subject
constexpr int kEdge = 2;                    // px on either side of the key's edge that are solved
constexpr int kHair = 20;                   // px from the subject in which hair is looked for
constexpr int kNear = 4, kFar = 14;  // px: windows in which the two sides are looked for, first the near one

// The mean of a measure over chosen pixels in a window around any pixel, by summed-area tables of the rows
// around the one that is asked about: few pixels ask.
class LocalMean {
 public:
  explicit LocalMean(int width, int height)
      : width_(width), height_(height), room_(static_cast<std::size_t>(width) + 1) {
    sums_.resize(kRows * room_);
    counts_.resize(kRows * room_);
  }

  // The next row of the measure.
  void add(const float* values, const std::uint64_t* chosen) {
    const std::size_t above = row(rows_), here = row(++rows_);
    const double* sums_above = sums_.data() + above;
    const int* counts_above = counts_.data() + above;
    double* sums = sums_.data() + here;
    int* counts = counts_.data() + here;
    double sum = 0;
    int count = 0;
    sums[0] = 0;
    counts[0] = 0;
    for (int x = 0; x < width_; ++x) {
      const auto one = static_cast<int>(chosen[x / 64] >> (x % 64) & 1U);
      sum += one != 0 ? static_cast<double>(values[x]) : 0;
      count += one;
      sums[x + 1] = sums_above[x + 1] + sum;
      counts[x + 1] = counts_above[x + 1] + count;
    }
  }
  // False, and 0, when no window holds a chosen pixel. Rows up to y + kFar must have been added, if there
  // are.
  bool at(int x, int y, float& mean) const {
    return window(x, y, kNear, 3, mean) || window(x, y, kFar, 1, mean);
  }

 private:
  static constexpr std::size_t kRows = 2 * kFar + 2;
  std::size_t row(int y) const { return static_cast<std::size_t>(y) % kRows * room_; }

  bool window(int x, int y, int radius, int at_least, float& mean) const {
    const int x0 = std::max(x - radius, 0), x1 = std::min(x + radius + 1, width_);
    const std::size_t top = row(std::max(y - radius, 0)), bottom = row(std::min(y + radius + 1, height_));
    const int count = box(counts_.data(), top, bottom, x0, x1);
    mean = count > 0 ? static_cast<float>(box(sums_.data(), top, bottom, x0, x1) / count) : 0;
    return count >= at_least;
  }
  template <class T>
  static T box(const T* table, std::size_t top, std::size_t bottom, int x0, int x1) {
    return table[bottom + static_cast<std::size_t>(x1)] - table[bottom + static_cast<std::size_t>(x0)] -
           table[top + static_cast<std::size_t>(x1)] + table[top + static_cast<std::size_t>(x0)];
  }

  int width_, height_, rows_ = 0;
  std::size_t room_;
  std::vector<double> sums_;  // row y: of what lies above it
  std::vector<int> counts_;
};

// The doubtful pixels that hang together with the subject and are not far from it.
BitRows hair_of(const BitRows& subject, BitRows candidates, BitMorphology& morphology) {
  BitRows reach;
  morphology.dilate(subject, kHair, reach);
  for (std::size_t i = 0; i < reach.all().size(); ++i)
    candidates.all()[i] = (candidates.all()[i] | subject.all()[i]) & reach.all()[i];
  BitComponents parts;
  parts.find(candidates, bounding_box(candidates), true);
  parts.touching(subject, candidates);
  return candidates;
}

// Off the edge, a little opacity is noise of the cloth; half opacity stays half.
float without_noise(float a) { return a >= 0.5f ? a : std::max(0.0f, (a - 0.25f) * 2); }

}  // namespace

void refine_edges(const BackingMeasure& measure, float contrast, const Image& doubt, Image& alpha) {
  if (alpha.empty()) return;
  BitBox box = bounding_box(alpha);
  if (box.empty()) return;
  constexpr int reach = kHair + kFar;
  box = {std::max(box.x0 - reach, 0), std::max(box.y0 - reach, 0), std::min(box.x1 + reach, alpha.width),
         std::min(box.y1 + reach, alpha.height)};
  BitMorphology morphology;
  BitRows subject, faint, doubtful, inside, edge, outside, asked;
  bits_of(alpha, box, kSubject, subject);
  bits_of(alpha, box, kFaint, faint);
  bits_of(doubt, box, 1, doubtful);
  const BitRows hair = hair_of(subject, std::move(doubtful), morphology);
  morphology.erode(subject, kEdge, inside);
  morphology.dilate(faint, kEdge, edge);
  outside.resize(subject.width(), subject.height());
  asked.resize(subject.width(), subject.height());
  for (std::size_t i = 0; i < asked.all().size(); ++i) {
    outside.all()[i] = ~(edge.all()[i] | hair.all()[i]);
    asked.all()[i] = ~(inside.all()[i] | outside.all()[i]);
  }

  const int width = subject.width(), height = subject.height();
  LocalMean of_inside(width, height), of_outside(width, height);
  // Measures of the rows that are still to be asked about.
  const auto room = static_cast<std::size_t>(width);
  std::vector<float> values((kFar + 1) * room);
  const auto row_of = [&](int y) { return values.data() + static_cast<std::size_t>(y % (kFar + 1)) * room; };
  for (int next = 0; next < height + kFar; ++next) {
    if (next < height) {
      float* row = row_of(next);
      measure(box.y0 + next, box.x0, width, row);
      outside.trim(next);
      of_inside.add(row, inside.row(next));
      of_outside.add(row, outside.row(next));
    }
    const int y = next - kFar;
    if (y < 0) continue;
    std::uint8_t* out = alpha.at(box.x0, box.y0 + y);
    const float* value = row_of(y);
    set_row(inside.row(y), width, 255, out);
    asked.trim(y);
    for_each_bit(asked, y, [&](int x) {
      float f, b;
      if (!of_outside.at(x, y, b)) return;
      of_inside.at(x, y, f);
      if (std::abs(f - b) < contrast) return;
      const float solved = (value[x] - b) / (f - b);
      const float opacity = edge.at(x, y) ? solved : without_noise(solved);
      out[x] = static_cast<std::uint8_t>(std::clamp(255 * opacity + 0.5f, 0.0f, 255.0f));
    });
  }
}

}  // namespace floatstage::matting
