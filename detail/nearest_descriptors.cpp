// Brute-force nearest neighbours as a matrix product in tiles that fit the registers, |a-b|^2 = |a|^2 + |b|^2
// - 2ab, with the two nearest of rows and columns kept while tiles are made: no matrix is ever stored.
// Compiled once for every instruction set that Highway knows here (docs/adr/0161, 0215).

#include "detail/nearest_descriptors.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detail/nearest_descriptors.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace floatstage::detail::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using F = HWY_FULL(float);
using V = hn::Vec<F>;

constexpr std::size_t kLength = PhotoFeatures::kLength;
constexpr std::size_t kRows = 6, kColumns = 2;  // of a tile: rows, and vectors of columns

/// One photograph's descriptors in floats, rows padded to whole tiles with what is far from everything.
struct Rows {
  std::size_t count = 0, padded = 0;
  std::vector<float> values, norms;
};

Rows rows_of(const PhotoFeatures& features, std::size_t multiple) {
  Rows rows;
  rows.count = static_cast<std::size_t>(features.count());
  rows.padded = (rows.count + multiple - 1) / multiple * multiple;
  rows.values.assign(rows.padded * kLength, 0);
  rows.norms.assign(rows.padded, Nearest::kNone);
  for (std::size_t i = 0; i < rows.count; ++i) {
    int norm = 0;
    for (std::size_t k = 0; k < kLength; ++k) {
      const int v = features.descriptors[i * kLength + k];
      rows.values[i * kLength + k] = static_cast<float>(v);
      norm += v * v;
    }
    rows.norms[i] = static_cast<float>(norm);
  }
  return rows;
}

// Number k of all descriptors of a vector of columns side by side.
std::vector<float> interleaved(const Rows& rows, std::size_t lanes) {
  std::vector<float> out(rows.values.size());
  for (std::size_t j = 0; j < rows.padded; ++j)
    for (std::size_t k = 0; k < kLength; ++k)
      out[(j / lanes * kLength + k) * lanes + j % lanes] = rows.values[j * kLength + k];
  return out;
}

/// The two nearest so far, lane by lane. Indices are whole numbers in floats.
struct State {
  std::vector<float> first, second, index;
  explicit State(std::size_t n) : first(n, 2 * Nearest::kNone), second(n, 2 * Nearest::kNone), index(n, 0) {}
};

HWY_INLINE void update(V distance, V index, float* first, float* second, float* indices) {
  const F d;
  const V old = hn::LoadU(d, first);
  const auto nearer = hn::Lt(distance, old);
  hn::StoreU(hn::Min(hn::LoadU(d, second), hn::Max(old, distance)), d, second);
  hn::StoreU(hn::Min(old, distance), d, first);
  hn::StoreU(hn::IfThenElse(nearer, index, hn::LoadU(d, indices)), d, indices);
}

// The tile of kRows rows from i and kColumns vectors of columns from j, against both states.
HWY_INLINE void tile(const float* a, const float* a_norms, const float* b, const float* b_norms,
                     std::size_t i, std::size_t j, V lane_numbers, State& row_state, State& column_state) {
  const F d;
  const std::size_t lanes = hn::Lanes(d);
  V s00 = hn::Zero(d), s01 = s00, s10 = s00, s11 = s00, s20 = s00, s21 = s00;
  V s30 = s00, s31 = s00, s40 = s00, s41 = s00, s50 = s00, s51 = s00;
  const float *b0 = b + j * kLength, *b1 = b0 + lanes * kLength;
  const float* row = a + i * kLength;
  for (std::size_t k = 0; k < kLength; ++k) {
    const V x = hn::LoadU(d, b0 + k * lanes), y = hn::LoadU(d, b1 + k * lanes);
    V r = hn::Set(d, row[k]);
    s00 = hn::MulAdd(r, x, s00), s01 = hn::MulAdd(r, y, s01);
    r = hn::Set(d, row[kLength + k]);
    s10 = hn::MulAdd(r, x, s10), s11 = hn::MulAdd(r, y, s11);
    r = hn::Set(d, row[2 * kLength + k]);
    s20 = hn::MulAdd(r, x, s20), s21 = hn::MulAdd(r, y, s21);
    r = hn::Set(d, row[3 * kLength + k]);
    s30 = hn::MulAdd(r, x, s30), s31 = hn::MulAdd(r, y, s31);
    r = hn::Set(d, row[4 * kLength + k]);
    s40 = hn::MulAdd(r, x, s40), s41 = hn::MulAdd(r, y, s41);
    r = hn::Set(d, row[5 * kLength + k]);
    s50 = hn::MulAdd(r, x, s50), s51 = hn::MulAdd(r, y, s51);
  }
  const V sums[kRows][kColumns] = {{s00, s01}, {s10, s11}, {s20, s21}, {s30, s31}, {s40, s41}, {s50, s51}};
  const V minus_two = hn::Set(d, -2.0F);
  for (std::size_t c = 0; c < kColumns; ++c) {
    const std::size_t column = j + c * lanes;
    const V norm = hn::LoadU(d, b_norms + column);
    const V numbers = hn::Add(lane_numbers, hn::Set(d, static_cast<float>(column)));
    for (std::size_t r = 0; r < kRows; ++r) {
      const V distance = hn::MulAdd(sums[r][c], minus_two, hn::Add(norm, hn::Set(d, a_norms[i + r])));
      float* const at = row_state.first.data() + r * lanes;
      update(distance, numbers, at, row_state.second.data() + r * lanes, row_state.index.data() + r * lanes);
      update(distance, hn::Set(d, static_cast<float>(i + r)), column_state.first.data() + column,
             column_state.second.data() + column, column_state.index.data() + column);
    }
  }
}

Nearest of_lanes(const float* first, const float* second, const float* index, std::size_t lanes) {
  Nearest best{static_cast<int>(index[0]), first[0], second[0]};
  for (std::size_t l = 1; l < lanes; ++l) {
    const int at = static_cast<int>(index[l]);
    if (first[l] < best.first || (first[l] == best.first && at < best.index)) {
      best.second = std::min(best.first, second[l]);
      best.first = first[l];
      best.index = at;
    } else {
      best.second = std::min(best.second, first[l]);
    }
  }
  best.second = std::min(best.second, Nearest::kNone);
  return best;
}

NearestBothWays compare(const PhotoFeatures& a, const PhotoFeatures& b) {
  const F d;
  const std::size_t lanes = hn::Lanes(d);
  const Rows of_a = rows_of(a, kRows), of_b = rows_of(b, kColumns * lanes);
  const std::vector<float> columns = interleaved(of_b, lanes);
  const V lane_numbers = hn::Iota(d, 0);
  State column_state(of_b.padded);
  NearestBothWays out;
  for (std::size_t i = 0; i < of_a.padded; i += kRows) {
    State row_state(kRows * lanes);
    for (std::size_t j = 0; j < of_b.padded; j += kColumns * lanes)
      tile(of_a.values.data(), of_a.norms.data(), columns.data(), of_b.norms.data(), i, j, lane_numbers,
           row_state, column_state);
    for (std::size_t r = 0; r < kRows && i + r < of_a.count; ++r)
      out.of_a.push_back(of_lanes(row_state.first.data() + r * lanes, row_state.second.data() + r * lanes,
                                  row_state.index.data() + r * lanes, lanes));
  }
  for (std::size_t j = 0; j < of_b.count; ++j)
    out.of_b.push_back(of_lanes(&column_state.first[j], &column_state.second[j], &column_state.index[j], 1));
  return out;
}

}  // namespace
}  // namespace floatstage::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::detail {
HWY_EXPORT(compare);

NearestBothWays nearest_both_ways(const PhotoFeatures& a, const PhotoFeatures& b) {
  if (a.count() == 0 || b.count() == 0)
    return {std::vector<Nearest>(a.points.size()), std::vector<Nearest>(b.points.size())};
  return HWY_DYNAMIC_DISPATCH(compare)(a, b);
}

}  // namespace floatstage::detail
#endif
