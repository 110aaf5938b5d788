#pragma once

#include "render/flow/flow_kernels.h"

// The inner loops of DepthSweep that FlowKernels does not have, each compiled for every instruction set. The
// same bits on all of them: nothing is contracted or approximated. All work on the blocks of `span`.
namespace floatstage::render {

/// A row of a direction field.
struct DirectionRow {
  ConstSplitRow x, y;
};

/// (x, y) = e * direction.
void depth_shift(SplitSpan span, ConstSplitRow e, const DirectionRow& direction, SplitRow x, SplitRow y);

/// What one image shows where it is read, and how far that is evidence.
struct ReadRow {
  ConstSplitRow value, weight;
};
/// Two images as one pair: mean brightness, difference (second - first), `share` of the evidence of both.
void depth_pair(SplitSpan span, float share, const ReadRow& first, const ReadRow& second, SplitRow mean,
                SplitRow difference, SplitRow weight);

/// What a pair says of the total displacement e: adds to `a` and `b` of a e = b. `dx`, `dy`: the gradient of
/// the pair's mean; `first`, `second`: the directions in which its images move.
struct DepthTerms {
  ThreeRows dx, dy, difference;
  ConstSplitRow weight, e;
  DirectionRow first, second;
};
void depth_terms(SplitSpan span, const FlowEnergy& energy, const DepthTerms& terms, SplitRow a, SplitRow b);

/// `a` becomes omega / (a + the weights towards the four neighbours), 0 where nothing holds the pixel.
void depth_invert(SplitSpan span, float omega, ConstSplitRow right, ConstSplitRow down,
                  ConstSplitRow down_above, SplitRow a);

/// One relaxation of the pixels of one parity (0: even columns) of a row.
void depth_relax(SplitSpan span, int parity, float omega, ConstSplitRow inverse, ConstSplitRow b,
                 ConstSplitRow right, ConstSplitRow down, ConstSplitRow down_above, const ThreeRows& e,
                 SplitRow out);

}  // namespace floatstage::render
