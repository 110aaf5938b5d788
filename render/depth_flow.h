#pragma once

#include <cstdint>
#include <vector>

#include "render/flow.h"
#include "render/flow/depth_sweep.h"
#include "render/flow/enlargement.h"
#include "render/image_fill.h"
#include "render/interruption.h"
#include "render/parallaxes.h"
#include "render/projected_images.h"

namespace floatstage::render {

/// One displacement a pixel for all images of a view at once. Where the proxy lacks a depth along the viewing
/// ray every image stands beside its place by its own parallax, and one number says by how much: e px, so
/// that image i is to be read at x + e * parallax_i. It is found as a flow is, from coarse to fine, by an
/// energy of all pairs of images; it is kept as far as it makes them more alike and continued elsewhere. One
/// unknown instead of 2 n (n - 1); what no depth explains (calibration, light) it cannot say. Deterministic.
/// One thread at a time; keeps its memory. docs/algorithms/floating-textures.md#one-depth-for-all, ADR 358.
class DepthFlow {
 public:
  /// `images` and `parallaxes` have one size and at least two images. Cancelled when it was interrupted:
  /// what is held is nobody's then.
  Result<void> estimate(const ProjectedImages& images, const Parallaxes& parallaxes,
                        Interruption* interruption = nullptr);

  const std::vector<float>& displacement() const { return e_; }         ///< px, width * height
  const std::vector<std::uint8_t>& believed() const { return known_; }  ///< how far it was, 0…255

  /// What image `image` shows at pixel (x, y) belongs to a pixel of the view, whose displacement is `e` and
  /// whose place in planes is `at`.
  struct Home {
    float e;
    std::size_t at;
  };
  Home home(const Parallaxes& parallaxes, std::size_t image, int x, int y) const;

 private:
  struct Level : DepthLevel {
    SplitPlane e;
  };
  void lay_out(const ProjectedImages& images, const Parallaxes& parallaxes, int levels);
  void solve(int levels);
  void judge(const ProjectedImages& images, const Parallaxes& parallaxes);
  void differ(const ProjectedImages& images, const Parallaxes& parallaxes, int y);

  int width_ = 0, height_ = 0;
  std::vector<PicturePyramid> pyramids_;
  std::vector<Level> levels_;
  std::vector<DepthPairShare> pairs_;
  DepthSweep sweep_;
  Enlargement enlargement_;
  std::vector<float> e_, row_;
  // Of rows, as sums along them: how far images are from one another as they are, as they are moved, and what
  // share of the pairs says so.
  std::vector<float> before_, after_, said_;
  std::vector<float> apart_[3];
  std::vector<std::vector<float>> read_;
  std::vector<std::vector<std::uint8_t>> own_;
  std::vector<std::uint8_t> known_;
  PictureFill fill_;
};

}  // namespace floatstage::render
