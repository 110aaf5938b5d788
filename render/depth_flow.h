#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/flow.h"
#include "render/flow/depth_judge.h"
#include "render/flow/depth_sweep.h"
#include "render/flow/enlargement.h"
#include "render/flow/field_solver.h"
#include "render/image_fill.h"
#include "render/interruption.h"
#include "render/parallaxes.h"
#include "render/projected_images.h"

namespace floatstage::render {

/// How far the surface lies off the proxy, one number a pixel for all images of a view at once. Where the
/// proxy lacks a depth along the viewing ray every image stands beside its place by its own parallax, and one
/// number e says by how much: image i is to be read at x + e * parallax_i. It is found as a flow is, from
/// coarse to fine, by an energy of all pairs of images; it is kept as far as it makes them more alike and
/// continued elsewhere. One unknown instead of 2 n (n - 1); what no depth explains (calibration, light) it
/// cannot say. Deterministic at any thread count. Keeps its memory.
/// docs/algorithms/floating-textures.md#one-depth-for-all, ADR 358, 359.
class DepthFlow {
 public:
  /// `images` and `parallaxes` have one size and at least two images; of `options`, those of the variational
  /// flow count. InvalidArgument for options that it does not have; Cancelled when it was interrupted: what
  /// is held is nobody's then.
  Result<void> estimate(const ProjectedImages& images, const Parallaxes& parallaxes,
                        const FlowOptions& options, int threads, Interruption* interruption = nullptr);

  /// Planes of the images' size: e in px, which goes on smoothly off the proxy, and how far it was believed,
  /// 0…255.
  const std::vector<float>& displacement() const { return e_; }
  std::vector<float>& displacement() { return e_; }  ///< may be changed
  const std::vector<std::uint8_t>& believed() const { return known_; }

 private:
  struct Level : DepthLevel {
    SplitPlane e;
  };
  void find_pairs(const Parallaxes& parallaxes);
  void lay_out(const ProjectedImages& images, const Parallaxes& parallaxes, int levels, int threads);
  void lay_out_surface(int level, int threads);
  void lay_out_directions(const Parallaxes& parallaxes, std::size_t image, int levels);
  DepthSweep::Problem problem(const SolverOptions& options, int level);
  void warp(const SolverOptions& options, int level, int threads);
  void hand_out(int threads);

  static constexpr std::size_t kMostWarps = 8;  // of a level

  std::vector<PicturePyramid> pyramids_;
  std::vector<Level> levels_;
  std::vector<DepthPairShare> pairs_;
  std::vector<std::vector<float>> rows_;  // scratch, one an image or a thread
  std::vector<DepthSweep> sweeps_;        // one a thread
  std::array<RowProgress, kMostWarps> progress_;
  Enlargement enlargement_;
  DepthJudge judge_;
  PictureFill fill_;
  std::vector<float> e_;
  std::vector<std::uint8_t> known_;
};

}  // namespace floatstage::render
