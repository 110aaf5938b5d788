#pragma once

#include <array>
#include <cstdint>

#include "render/flow/flow_kernels.h"

// The inner loops of DepthSweep and DepthJudge that FlowKernels does not have, each compiled for every
// instruction set. The same bits on all of them: nothing is contracted or approximated. All work on the
// blocks of `span`.
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

/// An image as it is and as it is read, and how far both are evidence.
struct ComparedRow {
  ConstSplitRow still, moved, weight;
};
/// How far images are apart, as they are and as they are read, and how much says so.
struct ApartRow {
  SplitRow still, moved, said;
};
/// Adds what two images differ by, `share` times.
void depth_differ(SplitSpan span, float share, const ComparedRow& first, const ComparedRow& second,
                  const ApartRow& apart);

/// What is summed over a neighbourhood of kBelievedAcross * kBelievedAcross px.
inline constexpr int kBelievedAcross = 5;
struct ApartSums {
  std::array<const float*, kBelievedAcross> still, moved, said;  ///< of a row each: sums along it
};
/// Sums along a row; `apart` goes on by half a neighbourhood at both ends.
void depth_sum(int width, const float* apart, float* sums);
/// How far a displacement is believed, 0…255: as far as images are alike where it leads (`usual`: steps apart
/// at which half is left), and more so than without it.
void depth_believe(int width, float usual, const ApartSums& sums, std::uint8_t* known);

}  // namespace floatstage::render
