#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::render {

/// A picture and its ever smaller copies, RGBA of 8 bits, or RGB where it is opaque: each level half as
/// large, rounded down, at least 1 (OpenGL 4.5, 8.14.3), down to 1 x 1. Means over the area that a texel
/// covers, so that odd sizes do not drift; colours weigh as much as they are opaque.
class MipPyramid {
 public:
  /// `picture`: 3 or 4 channels, not empty. `clear_border`: the outermost texels of every level have an
  /// opacity of 0, so that nothing of a patch shows beyond it at any level, and one of a pixel's size or less
  /// shows nothing at all (thesis 5.2.3).
  MipPyramid(const Image& picture, bool clear_border);

  const std::vector<Image>& levels() const { return levels_; }  ///< 4 channels; 3: opaque, no clear border
  std::size_t bytes() const;
  /// Straight RGBA, 0 to 1, at (u, v) in [0, 1] and beyond (clamped to the edge), linear within two levels
  /// and between them, at level of detail `lod` (clamped to the levels there are).
  Eigen::Vector4f sample(const Eigen::Vector2d& uv, double lod) const;

 private:
  std::vector<Image> levels_;
};

/// A texture whose parts may be sharper than the whole: a root and patches over it, each with a matrix of its
/// own (M. Eisemann, "Error-Concealed Image-Based Rendering", chapter 5). This is the reference in software.
class Zipmap {
 public:
  /// What lies beyond the root's edge.
  enum class Wrap { Repeat, Clamp, Mirror };

  /// A picture laid over the root. The same picture may be used by several patches.
  struct Patch {
    std::size_t picture = 0;  ///< index
    /// M_i: root's texture coordinates to the patch's, both 0 to 1 from the top left corner; a homography.
    Eigen::Matrix3d patch_from_root = Eigen::Matrix3d::Identity();
  };

  /// `root`: 3 channels. `pictures`: RGB or RGBA with straight opacity. `patches` are laid over the root in
  /// this order, so that the finest come last. InvalidArgument: an empty picture, a patch of a picture that
  /// there is not, a matrix without an inverse.
  static Result<Zipmap> make(const Image& root, const std::vector<Image>& pictures,
                             std::vector<Patch> patches);

  /// The colour at the root's coordinates `uv`, where a step of a pixel to the right and down is `du` and
  /// `dv`: the sum of Eq. 5.1 and 5.2. RGB, 0 to 1.
  Eigen::Vector3f shade(const Eigen::Vector2d& uv, const Eigen::Vector2d& du, const Eigen::Vector2d& dv,
                        Wrap wrap = Wrap::Clamp) const;
  /// Patches [first, last) over a colour that is there already: a pass of several (5.2.2).
  Eigen::Vector3f shade_over(Eigen::Vector3f under, const Eigen::Vector2d& uv, const Eigen::Vector2d& du,
                             const Eigen::Vector2d& dv, std::size_t first, std::size_t last, Wrap wrap) const;

  /// A picture of the texture on a plane: pixel (x, y) shows uv_from_pixel of its centre. The same at any
  /// number of threads.
  Image draw(const Eigen::Matrix3d& uv_from_pixel, int width, int height, Wrap wrap = Wrap::Clamp,
             int threads = 0) const;

  std::size_t bytes() const;  ///< of all texels
  /// What one texture with mip levels would need that is everywhere as fine as the finest patch is.
  double bytes_when_flat() const;
  /// Texels of the finest patch on one of the root, linear; 1 without patches.
  double finest() const;
  const std::vector<Patch>& patches() const { return patches_; }
  const MipPyramid& root() const { return root_; }
  const std::vector<MipPyramid>& pictures() const { return pictures_; }

 private:
  Zipmap(MipPyramid root, std::vector<MipPyramid> pictures, std::vector<Patch> patches);
  MipPyramid root_;
  std::vector<MipPyramid> pictures_;
  std::vector<Patch> patches_;
};

/// A root's coordinate in [0, 1] (5.2.4).
double wrapped(double coordinate, Zipmap::Wrap wrap);

/// The level of detail at which `picture` is seen where a pixel's steps to the right and down are `du` and
/// `dv` of its coordinates (OpenGL 4.5, 8.14.1); below 0: magnified.
double level_of_detail(const MipPyramid& picture, const Eigen::Vector2d& du, const Eigen::Vector2d& dv);

/// How a small step becomes one under the homography `h`, where `p` = h * (x, y, 1) lies before the horizon.
Eigen::Matrix2d step_under(const Eigen::Matrix3d& h, const Eigen::Vector3d& p);

/// A point shows nothing whose third homogeneous coordinate is not larger than this.
inline constexpr double kHorizon = 1e-9;

}  // namespace floatstage::render
