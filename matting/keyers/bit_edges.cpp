// Method:  the opacity of mixed pixels from a measure that is linear in the subject's share, on bits: summed
// tables
//          over a ring of rows
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996, eq. 1, along one axis; F. Crow,
// "Summed-area tables
//          for texture mapping", 1984
// Differs: as matting/refine_edges.cpp, which is the reference; sums are whole numbers
// ADR:     0043, 0195

#include "matting/keyers/bit_edges.h"

#include <algorithm>
#include <bit>

namespace floatstage::matting {
namespace {

// Those of refine_edges.cpp.
constexpr int kEdge = 2;             // px on either side of the key's edge that are solved
constexpr int kHair = 20;            // px from the subject in which hair is looked for
constexpr int kNear = 4, kFar = 14;  // px: windows in which the two sides are looked for, first the near one

constexpr int kRing = 32;  // rows of the tables that are kept: kFar above, kFar below, and the one before
static_assert(kRing >= 2 * kFar + 2);
constexpr int kCountBits = 24;  // of a table's entries: more than a ring's pixels
constexpr std::uint64_t kCounts = (std::uint64_t{1} << kCountBits) - 1;

// One pixel of a table: its value, and one counted. Wraps like the sums do: differences are right.
std::uint64_t entry(std::int32_t value) {
  return (static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) << kCountBits) + 1;
}

// table[x] = above[x] + the sum of what the mask chooses of the row before and at x.
void sum_row(const std::uint64_t* mask, const std::int32_t* values, int x0, int x1,
             const std::uint64_t* above, std::uint64_t* table) {
  std::uint64_t sum = 0;
  for (int x = x0; x < x1;) {
    const int end = std::min((x / 64 + 1) * 64, x1);
    const std::uint64_t bits = mask[x / 64];
    if (bits == 0) {
      for (; x < end; ++x) table[x] = above[x] + sum;
    } else if (bits == ~std::uint64_t{0}) {
      for (; x < end; ++x) table[x] = above[x] + (sum += entry(values[x]));
    } else {
      for (; x < end; ++x) {
        sum += entry(values[x]) & (std::uint64_t{0} - (bits >> (x % 64) & 1));
        table[x] = above[x] + sum;
      }
    }
  }
}

}  // namespace

void BitEdges::find(const BitRows& subject, const BitRows& faint, const BitRows& doubt) {
  box_ = grown(bounding_box(faint), kHair + kFar, faint);
  for (BitRows* made : {&candidates_, &outside_}) {
    made->resize(faint.width(), faint.height());
    made->clear();
  }
  morphology_.dilate(subject, kHair, reach_);
  const auto subject_bits = subject.all(), doubts = doubt.all();
  for (std::size_t w = 0; w < subject_bits.size(); ++w)
    candidates_.all()[w] = (doubts[w] | subject_bits[w]) & reach_.all()[w];
  components_.find(candidates_, box_, true);
  components_.touching(subject, hair_);
  morphology_.erode(subject, kEdge, inside_);
  morphology_.dilate(faint, kEdge, edge_);
  for (int y = box_.y0; y < box_.y1; ++y) {
    outside_.set(y, box_.x0, box_.x1);
    for (std::size_t w = 0; w < outside_.words(); ++w)
      outside_.row(y)[w] &= ~(edge_.row(y)[w] | hair_.row(y)[w]);
  }
}

void BitEdges::solve(const Rows& rows, const std::function<void(const Solved&)>& take) {
  if (box_.empty()) return;
  const std::size_t width = static_cast<std::size_t>(inside_.width());
  of_inside_.resize(width * kRing);
  of_outside_.resize(width * kRing);
  values_.resize(padded(width) + 64);
  for (Table* table : {&of_inside_, &of_outside_})  // the row above the first
    std::fill_n(table->begin() + static_cast<std::ptrdiff_t>(width) * ((box_.y0 + kRing - 1) % kRing), width,
                0);
  for (int y = box_.y0; y < box_.y1 + kFar; ++y) {
    if (y < box_.y1) {
      rows(y, box_.x0, box_.x1, values_.data());
      add_row(values_.data(), y);
    }
    if (y - kFar >= box_.y0) solve_row(y - kFar, take);
  }
}

void BitEdges::add_row(const std::int32_t* values, int y) {
  const std::size_t width = static_cast<std::size_t>(inside_.width());
  const std::size_t row = width * static_cast<std::size_t>(y % kRing),
                    above = width * static_cast<std::size_t>((y + kRing - 1) % kRing);
  sum_row(inside_.row(y), values, box_.x0, box_.x1, &of_inside_[above], &of_inside_[row]);
  sum_row(outside_.row(y), values, box_.x0, box_.x1, &of_outside_[above], &of_outside_[row]);
}

bool BitEdges::mean(const Table& table, int x, int y, float& out) const {
  const std::size_t width = static_cast<std::size_t>(inside_.width());
  const auto row = [&](int v) { return &table[width * static_cast<std::size_t>((v + kRing) % kRing)]; };
  for (const auto& [radius, at_least] : {std::pair(kNear, 3), std::pair(kFar, 1)}) {
    const int x0 = std::max(x - radius, box_.x0), x1 = std::min(x + radius + 1, box_.x1) - 1;
    const int y0 = std::max(y - radius, box_.y0), y1 = std::min(y + radius + 1, box_.y1) - 1;
    const std::uint64_t *top = row(y0 - 1), *bottom = row(y1);
    std::uint64_t sum = bottom[x1] - top[x1];
    if (x0 > box_.x0) sum -= bottom[x0 - 1] - top[x0 - 1];
    const std::uint64_t count = sum & kCounts;
    out = count > 0
              ? static_cast<float>(static_cast<double>(static_cast<std::int64_t>(sum - count) >> kCountBits) /
                                   (RowMeasure::kQuantum * static_cast<double>(count)))
              : 0;
    if (count >= static_cast<std::uint64_t>(at_least)) return true;
  }
  return false;
}

void BitEdges::solve_row(int y, const std::function<void(const Solved&)>& take) const {
  for (std::size_t w = static_cast<std::size_t>(box_.x0) / 64; w < inside_.words(); ++w) {
    std::uint64_t bits = (edge_.row(y)[w] | hair_.row(y)[w]) & ~inside_.row(y)[w];
    for (; bits != 0; bits &= bits - 1) {
      const int x = static_cast<int>(64 * w) + std::countr_zero(bits);
      Solved pixel{x, y, 0, 0, edge_.at(x, y), false};
      pixel.known = mean(of_outside_, x, y, pixel.backing);
      if (pixel.known) mean(of_inside_, x, y, pixel.subject);
      take(pixel);
    }
  }
}

}  // namespace floatstage::matting
