#include "render/flow/flow_sweep.h"

#include <algorithm>

#include "render/flow/row_wave.h"

namespace floatstage::render {
namespace {

constexpr int kNearRows = 4;  // rows that warp, gradient and diffusivity are looked back at, at most

}  // namespace

void FlowSweep::reset(int width, int height, int sweeps) {
  width_ = width;
  height_ = height;
  sweeps_ = sweeps;
  for (RowRing* ring : {&mean_, &difference_, &weight_, &dx_, &dy_, &diffusivity_})
    ring->reset(width, kNearRows);
  // The last half-sweep is 2 sweeps - 1 rows behind the equations and looks one row further back.
  const int rows = RowRing::rows_for(2 * sweeps + 3);
  for (RowRing* ring : {&right_, &down_, &i11_, &i12_, &i22_, &b1_, &b2_}) ring->reset(width, rows);
  relaxations_.resize(static_cast<std::size_t>(rows));
  none_.resize(width, 1);
}

ThreeRows FlowSweep::three(RowRing& ring, int y) const {
  return {ring[std::max(y - 1, 0)], ring[y], ring[std::min(y + 1, height_ - 1)]};
}

ThreeRows FlowSweep::three(const SplitPlane& plane, int y) const {
  return {plane.row(std::max(y - 1, 0)), plane.row(y), plane.row(std::min(y + 1, height_ - 1))};
}

void FlowSweep::run(const FlowKernels& kernels, const FlowEnergy& energy, bool cubic,
                    const PictureLevel& first, const PictureLevel& second, SplitPlane& u, SplitPlane& v) {
  const Task task{&kernels, &energy, cubic, &first, &second, second.sampled(), &u, &v};
  row_wave(
      height_, sweeps_, [&](int y) { warp_row(task, y); }, [&](int y) { differentiate_row(task, y); },
      [&](int y) { equate_row(task, y); }, [&](int y, int parity) { relax_row(task, y, parity); });
}

void FlowSweep::warp_row(const Task& task, int y) {
  const SplitSpan span = task.span(y);
  diffusivity_.clear(y);  // outside the span nothing is coupled
  if (span.empty()) return;
  const int below = std::min(y + 1, height_ - 1);
  const SplitRow u = task.u->row(y), v = task.v->row(y), u_below = task.u->row(below),
                 v_below = task.v->row(below);
  task.kernels->warp(span, y, task.cubic, u, v, task.first->first.row(y), task.first->data.row(y),
                     task.target, mean_[y], difference_[y], weight_[y]);
  for (SplitRow row : {u, v, mean_[y], difference_[y]}) replicate_ends(row, width_);
  task.kernels->diffusivity(span, *task.energy, u, u_below, v, v_below, task.first->stiffness.row(y),
                            diffusivity_[y]);
}

void FlowSweep::differentiate_row(const Task& task, int y) {
  const SplitSpan span = task.span(y);
  down_.clear(y);
  if (span.empty()) return;
  task.kernels->gradient(span, three(mean_, y), dx_[y], dy_[y]);
  replicate_ends(dx_[y], width_);
  const ConstSplitRow below = y + 1 < height_ ? ConstSplitRow(diffusivity_[y + 1]) : none_.row(0);
  task.kernels->neighbors(span, diffusivity_[y], below, right_[y], down_[y]);
  right_[y].odd[span.begin - 1] = 0;  // the neighbour to the left of the span
}

void FlowSweep::equate_row(const Task& task, int y) {
  const SplitSpan span = task.span(y);
  Relaxation& relaxation = relaxations_[static_cast<std::size_t>(y) & (relaxations_.size() - 1)];
  relaxation.span = span;
  if (span.empty()) return;
  relaxation = {span,          equations(y),      right_[y],         down_[y],
                down_above(y), three(*task.u, y), three(*task.v, y), task.u->row(y),
                task.v->row(y)};
  task.kernels->equations(span, *task.energy, three(dx_, y), three(dy_, y), three(difference_, y), weight_[y],
                          relaxation.u_out, relaxation.v_out, relaxation.right, relaxation.down,
                          relaxation.down_above, relaxation.equations);
}

void FlowSweep::relax_row(const Task& task, int y, int parity) const {
  const Relaxation& r = relaxations_.data()[static_cast<std::size_t>(y) & (relaxations_.size() - 1)];
  if (r.span.empty()) return;
  task.kernels->relax(r.span, parity, task.energy->omega, r.equations, r.right, r.down, r.down_above, r.u,
                      r.v, r.u_out, r.v_out);
}

}  // namespace floatstage::render
