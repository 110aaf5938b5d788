#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/flow/split_plane.h"

namespace floatstage::render {

/// A picture that is read where displacements point to. A sample is the grey value in 1/128 steps in its
/// upper 15 bits, and in its lowest bit whether the value is evidence. kSampleMargin samples lie around the
/// picture on every side; values go on there, evidence does not.
constexpr int kSampleMargin = 3;
struct SampledPicture {
  const std::uint16_t* origin = nullptr;  ///< the sample of pixel (0, 0)
  int stride = 0;                         ///< samples from row to row
  int width = 0, height = 0;
};

/// What the kernels need of the energy (Brox et al. 2004, with the data terms normalised as in Zimmer et al.
/// 2009). Lengths in px, brightness in 8-bit steps.
struct FlowEnergy {
  float gradient_weight = 5;      ///< gamma: the gradient's constancy against the brightness's
  float noise2 = 1;               ///< zeta^2: gradients below it say little
  float data_epsilon2 = 0.01F;    ///< of the Charbonnier penalty of the data terms
  float smooth_epsilon2 = 0.01F;  ///< of that of the smoothness
  float omega = 1.9F;             ///< over-relaxation
};

/// The linear equations of one row of pixels for the total displacement (u, v):
/// u = i11 su - i12 sv, v = i22 sv - i12 su, where su = b1 + sum over the four neighbours of w u; the inverse
/// already holds omega. `right` and `down` are the weights w towards the next column and row.
struct EquationRow {
  SplitRow i11, i12, i22, b1, b2;
};

/// The rows that one derivative needs: above, here, below.
struct ThreeRows {
  ConstSplitRow above, here, below;
};

/// The inner loops of the solver. Every set computes the same bits: each operation is one IEEE operation in
/// the order that flow_kernels_scalar.cpp writes down, nothing is contracted or approximated. All work on the
/// blocks of `span`.
struct FlowKernels {
  std::string name;  ///< "scalar", "AVX2", …

  /// `second`, read at (x + u, y + v), against `first`: mean brightness, difference (second - first), and
  /// the weight of the data, which is `data` where all that is read is evidence and 0 elsewhere. Read
  /// bilinearly or, `cubic`, by Catmull-Rom splines.
  void (*warp)(SplitSpan span, int y, bool cubic, ConstSplitRow u, ConstSplitRow v, ConstSplitRow first,
               ConstSplitRow data, const SampledPicture& second, SplitRow mean, SplitRow difference,
               SplitRow weight);

  /// Central differences of `mean`.
  void (*gradient)(SplitSpan span, const ThreeRows& mean, SplitRow dx, SplitRow dy);

  /// stiffness / sqrt(|grad u|^2 + |grad v|^2 + epsilon^2), by forward differences.
  void (*diffusivity)(SplitSpan span, const FlowEnergy& energy, ConstSplitRow u, ConstSplitRow u_below,
                      ConstSplitRow v, ConstSplitRow v_below, ConstSplitRow stiffness, SplitRow diffusivity);

  /// The weights between neighbours: geometric means of the diffusivities, so 0 next to a 0.
  void (*neighbors)(SplitSpan span, ConstSplitRow here, ConstSplitRow below, SplitRow right, SplitRow down);

  /// Linearises the data terms around (u, v) and inverts the 2x2 system of each pixel.
  void (*equations)(SplitSpan span, const FlowEnergy& energy, const ThreeRows& dx, const ThreeRows& dy,
                    const ThreeRows& difference, ConstSplitRow weight, ConstSplitRow u, ConstSplitRow v,
                    ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above,
                    const EquationRow& out);

  /// One relaxation of the pixels of one parity (0: even columns) of a row.
  void (*relax)(SplitSpan span, int parity, float omega, const EquationRow& equations, ConstSplitRow right,
                ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& u, const ThreeRows& v,
                SplitRow u_out, SplitRow v_out);
};

/// Plain C++: what the others are tested against.
const FlowKernels& scalar_flow_kernels();
/// The best that this machine has (Highway: SSE2 … AVX-512, NEON). Chosen once.
const FlowKernels& native_flow_kernels();
/// Every set that this machine can run, the scalar one first: for tests and benches.
std::vector<FlowKernels> all_flow_kernels();

}  // namespace floatstage::render
