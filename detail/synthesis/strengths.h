#pragma once

#include <array>
#include <vector>

#include "detail/synthesis/exemplars.h"

namespace floatstage::detail {

/// How strong details are expected to be all over the root, by what it shows there: learned where close
/// photographs show both. Borrowed details are brought nearer to that strength, the more the less a place
/// differs from what was learned from (docs/adr/0309).
class Strengths {
 public:
  /// Of a cell of 2 x 2 pixels: what differs along x, along y, and crosswise.
  static constexpr std::size_t kParts = 3;
  using Gains = std::array<float, kParts>;

  Strengths() = default;
  /// `root`: level 0. `levels`: the finest.
  Strengths(const ColorGrid& root, const std::vector<LayerPyramid>& layers, const Exemplars& exemplars,
            int levels);

  /// Factors, 0.5 to 2, for the details of `place` in a cell of `level`, (x, y) counted in cells; 1 where too
  /// little was there to learn from.
  Gains gains(int level, int x, int y, Exemplars::Place place) const;

 private:
  using Logs = std::array<float, kParts>;  // ln(mean square + 1)
  struct Expected {
    Logs logs{};
    float share = 0;  // of the way to there that a gain goes
  };
  struct Level {
    Grid<Expected> expected;  // by step_ pixels of the root; empty: not known
    Grid<Logs> borrowed;      // by pixel of level 0 of the exemplars
    int exemplars_width = 1;
  };
  friend class StrengthLearner;

  int step_ = 1;
  std::vector<Level> levels_;
};

}  // namespace floatstage::detail
