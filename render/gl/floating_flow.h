#pragma once

#include <optional>
#include <span>
#include <vector>

#include "render/gl/flow_compute.h"
#include "render/gl/pull_push.h"

namespace floatstage::render {

/// PairwiseFlows on the GPU: the variational flow between all ordered pairs of projected images, kept where
/// it is believed (FlowTrust) and continued elsewhere (PictureFill), without its jitter. Pictures and fields
/// stay on the GPU. GL thread.
class FloatingFlow {
 public:
  static Result<FloatingFlow> create(FlowPrecision precision);

  /// `images` (RGBA8 as shaders/project.comp writes them, a layer an image) holds `width` * `height` px;
  /// `wanted`, one an image: is I_i -> I_j asked for, or zero? `flows` becomes an array of layers i * (n - 1)
  /// + (j < i ? j : j - 1) at 1/options.shrink of the size, filtered linearly, in px of its own.
  Result<void> run(const gl::Texture& images, int width, int height, const std::vector<bool>& wanted,
                   const FlowOptions& options, gl::Texture& flows);

  /// The second half alone: from fields of `solver` between pictures (FlowCompute::solve's) to `flows`.
  void make_dependable(const FlowCompute& solver, const FlowTables& tables, const gl::Texture& gray_and_state,
                       int width, int height, gl::Texture& flows);

 private:
  FloatingFlow(FlowCompute solver, FlowPrecision precision)
      : solver_(std::move(solver)), precision_(precision) {}

  FlowCompute solver_;
  FlowPrecision precision_;
  FlowTables tables_;
  gl::Kernel gray_, trust_, settle_;
  gl::Texture gray_and_state_;
  std::optional<gl::PullPush> fill_;  // made by create()
};

}  // namespace floatstage::render
