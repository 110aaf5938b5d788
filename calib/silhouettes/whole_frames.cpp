#include "calib/silhouettes/whole_frames.h"

#include <algorithm>
#include <cmath>

#include "core/statistics.h"

namespace floatstage::calib {
namespace {

constexpr int kFewestShared = 8;         // instants at which both are seen, once they are brought together
constexpr double kClearly = 0.5;         // of what tangents lay apart before
constexpr int kOfFractions = 2;          // frames: up to there offsets are found as fractions
constexpr std::size_t kFewestPairs = 2;  // tangents that say so

// How far a tangent's two curves lie from one another, but for a constant, when a's picture k shows the
// instant k + offset_a. Negative: too few instants are shared.
double apart(const SharedTangent& tangent, int offset_a, int offset_b) {
  std::vector<double> differences;
  const int count = static_cast<int>(std::min(tangent.in_a.size(), tangent.in_b.size()));
  for (int k = 0; k < count; ++k) {
    const int in_a = k - offset_a, in_b = k - offset_b;
    if (in_a < 0 || in_b < 0 || in_a >= count || in_b >= count) continue;
    const double d =
        tangent.in_a[static_cast<std::size_t>(in_a)] - tangent.in_b[static_cast<std::size_t>(in_b)];
    if (!std::isnan(d)) differences.push_back(d);
  }
  if (static_cast<int>(differences.size()) < kFewestShared) return -1;
  const double constant = median(differences);
  for (double& d : differences) d = std::abs(d - constant);
  return median(std::move(differences));
}

struct Move {
  double ratio = 1;  // of what is left
  int offset = 0;
};

// What would bring a camera's tangents nearest to the others'.
Move best_move(int camera, std::span<const SharedTangent> tangents, const std::vector<int>& offsets) {
  Move best;
  const int now = offsets[static_cast<std::size_t>(camera)];
  for (int offset = -kMostWholeFrames; offset <= kMostWholeFrames; ++offset) {
    if (std::abs(offset - now) < kOfFractions) continue;
    double before = 0, after = 0;
    std::size_t pairs = 0;
    for (const SharedTangent& tangent : tangents) {
      if (tangent.a != camera && tangent.b != camera) continue;
      const int a = offsets[static_cast<std::size_t>(tangent.a)],
                b = offsets[static_cast<std::size_t>(tangent.b)];
      const double as_is = apart(tangent, a, b),
                   moved = tangent.a == camera ? apart(tangent, offset, b) : apart(tangent, a, offset);
      if (as_is < 0 || moved < 0) continue;
      before += as_is, after += moved, ++pairs;
    }
    if (pairs >= kFewestPairs && after < best.ratio * before) best = {after / before, offset};
  }
  return best;
}

}  // namespace

std::vector<int> whole_frames_apart(std::size_t cameras, std::span<const SharedTangent> tangents) {
  std::vector<int> offsets(cameras, 0);
  for (std::size_t round = 0; round < cameras; ++round) {
    Move best;
    std::size_t moved = 0;
    for (std::size_t c = 0; c < cameras; ++c)
      if (const Move move = best_move(static_cast<int>(c), tangents, offsets); move.ratio < best.ratio)
        best = move, moved = c;
    if (best.ratio > kClearly) break;
    offsets[moved] = best.offset;
  }
  return offsets;
}

}  // namespace floatstage::calib
