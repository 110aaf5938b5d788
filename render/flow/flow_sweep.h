#pragma once

#include <vector>

#include "render/flow/flow_kernels.h"
#include "render/flow/picture_pyramid.h"
#include "render/flow/row_ring.h"
#include "render/flow/split_plane.h"

namespace floatstage::render {

/// One warp of a field at one level: the second picture is read where the field points to, the energy is
/// linearised there, and the linear equations are relaxed (red-black SOR).
///
/// All of it goes over the picture once, row by row as a wavefront: while row t is warped, row t - 1 is
/// differentiated, row t - 2 gets its equations and half-sweep h relaxes row t - 2 - h. Each step finds what
/// it needs in the rows just made, and the result is the same, bit by bit, as that of one pass after the
/// other. So the equations of only a few rows exist at a time, in the cache.
class FlowSweep {
 public:
  /// Prepares for pictures of this size. Takes memory only when something is larger than ever before.
  void reset(int width, int height, int sweeps);
  /// Improves (u, v). Both levels have the size given to reset(), and so do u and v.
  void run(const FlowKernels& kernels, const FlowEnergy& energy, bool cubic, const PictureLevel& first,
           const PictureLevel& second, SplitPlane& u, SplitPlane& v);

 private:
  struct Task {
    const FlowKernels* kernels;
    const FlowEnergy* energy;
    bool cubic;
    const PictureLevel *first, *second;
    SampledPicture target;
    SplitPlane *u, *v;
    SplitSpan span(int y) const { return first->spans[static_cast<std::size_t>(y)]; }
  };
  /// What relaxing a row reads and writes: looked up once for all its half-sweeps, of which each has little
  /// more to do than a look-up takes.
  struct Relaxation {
    SplitSpan span;
    EquationRow equations;
    ConstSplitRow right, down, down_above;
    ThreeRows u, v;
    SplitRow u_out, v_out;
  };
  void warp_row(const Task& task, int y);
  void differentiate_row(const Task& task, int y);
  void equate_row(const Task& task, int y);
  void relax_row(const Task& task, int y, int parity) const;
  EquationRow equations(int y) { return {i11_[y], i12_[y], i22_[y], b1_[y], b2_[y]}; }
  ConstSplitRow down_above(int y) { return y > 0 ? ConstSplitRow(down_[y - 1]) : none_.row(0); }
  ThreeRows three(RowRing& ring, int y) const;
  ThreeRows three(const SplitPlane& plane, int y) const;

  int width_ = 0, height_ = 0, sweeps_ = 0;
  RowRing mean_, difference_, weight_, dx_, dy_, diffusivity_, right_, down_, i11_, i12_, i22_, b1_, b2_;
  SplitPlane none_;                      // one row of zeros
  std::vector<Relaxation> relaxations_;  // of row y in y % size, as long as its equations
};

}  // namespace floatstage::render
