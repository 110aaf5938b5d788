#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "render/flow/depth_kernels.h"
#include "render/flow/flow_kernels.h"
#include "render/flow/picture_pyramid.h"
#include "render/flow/row_progress.h"
#include "render/flow/row_ring.h"
#include "render/flow/split_plane.h"

namespace floatstage::render {

/// One level of what a displacement along the viewing ray is found from. All pictures have one size and one
/// domain.
struct DepthLevel {
  struct Direction {
    SplitPlane x, y;
  };
  std::vector<const PictureLevel*> pictures;
  std::vector<Direction> directions;  ///< of each picture: px a px of displacement; 0 outside the domain
  SplitPlane inside;                  ///< 1 in the domain, else 0
  SplitPlane stiffness;               ///< the mean of the pictures'
};

/// Two pictures and how much they count.
struct DepthPairShare {
  std::size_t first, second;
  float share;
};

/// One warp of one displacement e that all pictures share: picture i is read at x + e direction_i, the energy
/// of all pairs is linearised there, and the linear equations are relaxed (red-black SOR). Goes over the rows
/// as FlowSweep does, so that the next warp may follow on another thread a few rows behind.
class DepthSweep {
 public:
  /// Of one level, what all warps of it share.
  struct Problem {
    const FlowKernels* kernels;
    const FlowEnergy* energy;
    bool cubic;  ///< pictures are read by splines
    const DepthLevel* level;
    std::span<const DepthPairShare> pairs;
    SplitPlane* e;
    SplitSpan span(int y) const { return level->pictures[0]->spans[static_cast<std::size_t>(y)]; }
  };
  /// Takes memory only when something is larger than ever before.
  void reset(int width, int height, int sweeps, std::size_t pictures, std::size_t pairs);
  /// `before`: of the warp before this one, which may be under way (null: none is); `done`: of this one.
  void run(const Problem& problem, const RowProgress* before, RowProgress& done);

 private:
  struct Picture {
    RowRing value, weight;
  };
  struct Pair {
    RowRing mean, difference, weight, dx, dy;
  };
  void warp_row(const Problem& problem, int y);
  void differentiate_row(const Problem& problem, int y);
  void equate_row(const Problem& problem, int y);
  void relax_row(const Problem& problem, int y, int parity);
  ConstSplitRow down_above(int y) { return y > 0 ? ConstSplitRow(down_[y - 1]) : none_.row(0); }
  ThreeRows three(RowRing& ring, int y) const;

  int width_ = 0, height_ = 0, sweeps_ = 0;
  std::vector<Picture> pictures_;
  std::vector<Pair> pairs_;
  RowRing shift_x_, shift_y_, mean_, diffusivity_, right_, down_, inverse_, b_;
  SplitPlane none_;  // one row of zeros
};

}  // namespace floatstage::render
