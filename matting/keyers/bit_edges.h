#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "matting/keyers/bit_rows.h"
#include "matting/keyers/row_measure.h"

// Private to the stage.
namespace floatstage::matting {

/// refine_edges() (matting/refine_edges.h) on bits: the pixels whose opacity is to be solved, and the means
/// on both sides of them. Measures are rounded to 1 / RowMeasure::kQuantum before they are summed, so sums
/// are exact in any order.
class BitEdges {
 public:
  struct Solved {
    int x, y;
    float subject, backing;  ///< means of the measure on both sides; subject is 0 where none is near
    bool on_edge;            ///< else loose hair
    bool known;              ///< false: there is no backing near, and the key stays
  };
  /// Writes the measure of row y, columns x0 … x1 - 1 to out[x0] ….
  using Rows = std::function<void(int y, int x0, int x1, std::int32_t* out)>;

  /// Of a cleaned key: `subject` of at least 128, `faint` of at least 24; `doubt` as refine_edges() has it.
  void find(const BitRows& subject, const BitRows& faint, const BitRows& doubt);
  /// Where opacity is 255.
  const BitRows& inside() const { return inside_; }
  /// All pixels to be solved, row by row.
  void solve(const Rows& rows, const std::function<void(const Solved&)>& take);

 private:
  using Table = std::vector<std::uint64_t>;  // rows of a ring: sums in the upper 40 bits, counts below
  void add_row(const std::int32_t* values, int y);
  bool mean(const Table& table, int x, int y, float& out) const;
  void solve_row(int y, const std::function<void(const Solved&)>& take) const;

  BitMorphology morphology_;
  BitComponents components_;
  BitRows reach_, candidates_, inside_, edge_, hair_, outside_;
  BitBox box_;
  Table of_inside_, of_outside_;
  std::vector<std::int32_t> values_;
};

}  // namespace floatstage::matting
