#pragma once

#include <array>

#include "render/gl/flow_levels.h"

namespace floatstage::render {

/// The variational flow (render/flow/variational_flow.h) in compute kernels: the same pyramids, energy, warps
/// and red-black sweeps in the same order, for all fields at once, one layer a field. Nothing comes back to
/// the processor. GL thread.
class FlowCompute {
 public:
  static Result<FlowCompute> create(FlowPrecision precision);

  /// The fields of `tables` between the pictures in `gray_and_state` (RG8UI: brightness, FlowImage::state; a
  /// layer a picture), of which `width` * `height` px are used. `fused` sweeps are done in shared memory
  /// between two visits to memory, 1 … kMostFused; the result does not depend on it but for rounding to
  /// FlowPrecision.
  static constexpr int kFused = 5, kMostFused = 12;
  void solve(const VariationalPreset& preset, const FlowTables& tables, const gl::Texture& gray_and_state,
             int width, int height, int fused = kFused);

  /// Layer i is field i, in px; meaningless outside the domain (zone_and_own of level 0) and where a field
  /// was not asked for. Valid until the next solve().
  const gl::Texture& fields() const { return fields_[0][static_cast<std::size_t>(current_)]; }
  const FlowLevels& levels() const { return levels_; }

 private:
  FlowCompute(FlowLevels levels, FlowPrecision precision)
      : levels_(std::move(levels)), precision_(precision) {}
  void reserve(const FlowTables& tables);
  void enlarge(const VariationalPreset& preset, const FlowTables& tables, int l);
  void warp(const SolverOptions& options, const FlowTables& tables, int l);

  FlowLevels levels_;
  FlowPrecision precision_;
  gl::Kernel enlarge_, guided_, equations_, relax_;
  std::vector<std::array<gl::Texture, 2>> fields_;  // per level: what is read and what is written, in turns
  int current_ = 0;                                 // of a level's two, the one that holds the field
  gl::Texture tensor_and_right_, sides_and_down_;   // of the level at work
  std::array<gl::Texture, 2> increments_;
};

}  // namespace floatstage::render
