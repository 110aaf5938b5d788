#pragma once

#include <vector>

#include "render/flow.h"
#include "render/flow/enlargement.h"
#include "render/flow/flow_sweep.h"
#include "render/flow/picture_pyramid.h"

namespace floatstage::render {

/// How hard one field is worked on.
struct SolverOptions {
  int finest = 0;        ///< the level at which the solver stops
  int finest_warps = 2;  ///< warps there; one more at each coarser level …
  int most_warps = 5;    ///< … up to so many
  int sweeps = 5;        ///< of SOR after each warp at the finest level; twice, then four times as many above
  bool cubic = false;    ///< warps read splines
  float guide_edge = 5;  ///< 8-bit steps: Enlargement::guided
  FlowEnergy energy;

  int warps_at(int level) const;
  /// A coarser level is cheap, and what it leaves undone no finer one can reach.
  int sweeps_at(int level) const;
};

/// Solves one field after the other in memory that it keeps.
class FieldSolver {
 public:
  /// Both pyramids have the same size and `levels` levels, more than options.finest. `initial` may be null;
  /// it has the pictures' size, and so will `result`.
  void solve(const FlowKernels& kernels, const SolverOptions& options, const PicturePyramid& first,
             const PicturePyramid& second, int levels, const FlowField* initial, FlowField& result);

 private:
  struct Field {
    SplitPlane u, v;
  };
  void begin(const PictureLevel& level, const FlowField* initial, int l);

  FlowSweep sweep_;
  Enlargement enlargement_;
  std::vector<Field> fields_;  // one a level, so that each keeps its size
};

}  // namespace floatstage::render
