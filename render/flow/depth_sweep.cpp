#include "render/flow/depth_sweep.h"

#include <algorithm>

#include "render/flow/row_wave.h"

namespace floatstage::render {
namespace {

constexpr int kTold = 8;      // rows: waking who waits for each would cost more than it gains
constexpr int kNearRows = 4;  // rows that warp, gradient and diffusivity are looked back at, at most

DirectionRow direction_row(const DepthLevel::Direction& direction, int y) {
  return {direction.x.row(y), direction.y.row(y)};
}

}  // namespace

void DepthSweep::reset(int width, int height, int sweeps, std::size_t pictures, std::size_t pairs) {
  width_ = width;
  height_ = height;
  sweeps_ = sweeps;
  pictures_.resize(std::max(pictures_.size(), pictures));
  pairs_.resize(std::max(pairs_.size(), pairs));
  for (std::size_t i = 0; i < pictures; ++i)
    for (RowRing* ring : {&pictures_[i].value, &pictures_[i].weight}) ring->reset(width, 1);
  for (std::size_t p = 0; p < pairs; ++p)
    for (RowRing* ring :
         {&pairs_[p].mean, &pairs_[p].difference, &pairs_[p].weight, &pairs_[p].dx, &pairs_[p].dy})
      ring->reset(width, kNearRows);
  for (RowRing* ring : {&shift_x_, &shift_y_, &mean_}) ring->reset(width, 1);
  diffusivity_.reset(width, kNearRows);
  // The last half-sweep is 2 sweeps - 1 rows behind the equations and looks one row further back.
  for (RowRing* ring : {&right_, &down_, &inverse_, &b_})
    ring->reset(width, RowRing::rows_for(2 * sweeps + 3));
  none_.resize(width, 1);
}

ThreeRows DepthSweep::three(RowRing& ring, int y) const {
  return {ring[std::max(y - 1, 0)], ring[y], ring[std::min(y + 1, height_ - 1)]};
}

void DepthSweep::run(const Problem& problem, const RowProgress* before, RowProgress& done) {
  const int halves = 2 * sweeps_;
  row_wave(
      height_, sweeps_,
      [&](int y) {
        if (y % kTold == 0) done.tell(y - 1 - halves);  // those that the last half-sweep has left
        if (before != nullptr) before->await(std::min(y + 2, height_));
        warp_row(problem, y);
      },
      [&](int y) { differentiate_row(problem, y); }, [&](int y) { equate_row(problem, y); },
      [&](int y, int parity) { relax_row(problem, y, parity); });
  done.tell(height_);
}

// Reads every picture where e points to, and compares them in pairs.
void DepthSweep::warp_row(const Problem& problem, int y) {
  const SplitSpan span = problem.span(y);
  const DepthLevel& level = *problem.level;
  diffusivity_.clear(y);  // outside the span nothing is coupled
  if (span.empty()) return;
  const SplitRow e = problem.e->row(y), below = problem.e->row(std::min(y + 1, height_ - 1));
  for (std::size_t i = 0; i < level.pictures.size(); ++i) {
    depth_shift(span, e, direction_row(level.directions[i], y), shift_x_[y], shift_y_[y]);
    problem.kernels->warp(span, y, problem.cubic, shift_x_[y], shift_y_[y], none_.row(0), level.inside.row(y),
                          level.pictures[i]->sampled(), mean_[y], pictures_[i].value[y],
                          pictures_[i].weight[y]);
  }
  for (std::size_t p = 0; p < problem.pairs.size(); ++p) {
    const DepthPairShare& pair = problem.pairs[p];
    Picture &first = pictures_[pair.first], &second = pictures_[pair.second];
    Pair& out = pairs_[p];
    depth_pair(span, pair.share, {first.value[y], first.weight[y]}, {second.value[y], second.weight[y]},
               out.mean[y], out.difference[y], out.weight[y]);
    for (SplitRow row : {out.mean[y], out.difference[y]}) replicate_ends(row, width_);
  }
  replicate_ends(e, width_);
  problem.kernels->diffusivity(span, *problem.energy, e, below, none_.row(0), none_.row(0),
                               level.stiffness.row(y), diffusivity_[y]);
}

void DepthSweep::differentiate_row(const Problem& problem, int y) {
  const SplitSpan span = problem.span(y);
  down_.clear(y);
  if (span.empty()) return;
  for (std::size_t p = 0; p < problem.pairs.size(); ++p) {
    Pair& pair = pairs_[p];
    problem.kernels->gradient(span, three(pair.mean, y), pair.dx[y], pair.dy[y]);
    replicate_ends(pair.dx[y], width_);
  }
  const ConstSplitRow below = y + 1 < height_ ? ConstSplitRow(diffusivity_[y + 1]) : none_.row(0);
  problem.kernels->neighbors(span, diffusivity_[y], below, right_[y], down_[y]);
  right_[y].odd[span.begin - 1] = 0;  // the neighbour to the left of the span
}

void DepthSweep::equate_row(const Problem& problem, int y) {
  const SplitSpan span = problem.span(y);
  if (span.empty()) return;
  inverse_.clear(y);
  b_.clear(y);
  for (std::size_t p = 0; p < problem.pairs.size(); ++p) {
    const DepthPairShare& shared = problem.pairs[p];
    Pair& pair = pairs_[p];
    depth_terms(span, *problem.energy,
                {three(pair.dx, y), three(pair.dy, y), three(pair.difference, y), pair.weight[y],
                 problem.e->row(y), direction_row(problem.level->directions[shared.first], y),
                 direction_row(problem.level->directions[shared.second], y)},
                inverse_[y], b_[y]);
  }
  depth_invert(span, problem.energy->omega, right_[y], down_[y], down_above(y), inverse_[y]);
}

void DepthSweep::relax_row(const Problem& problem, int y, int parity) {
  const SplitSpan span = problem.span(y);
  if (span.empty()) return;
  SplitPlane& e = *problem.e;
  depth_relax(span, parity, problem.energy->omega, inverse_[y], b_[y], right_[y], down_[y], down_above(y),
              {e.row(std::max(y - 1, 0)), e.row(y), e.row(std::min(y + 1, height_ - 1))}, e.row(y));
}

}  // namespace floatstage::render
