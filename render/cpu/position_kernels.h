#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "render/camera_choice.h"
#include "render/cpu/photo_kernels.h"

// How much each camera's idea of a position counts, over lists of pixels. Formulas:
// render/gl/shaders/positions.glsl; derivation: docs/algorithms/floating-textures.md.
namespace floatstage::render::cpu {

/// Shares below it do not count.
inline constexpr float kFaintShare = 1.F / 1024;
/// A camera that looks along the surface has no parallax beyond this cosine's.
inline constexpr float kGrazing = 0.1F;

/// A row's list of pixels with the surface there. Lists are padded to Covered::kAlign.
struct PositionRow {
  int count = 0, cameras = 0;
  const float* x = nullptr;  ///< px of the window
  float y = 0;
  const float* inverse_z = nullptr;
  Normals normals{};
  /// In: the cameras' angular weights, with sum 1. Out: their position weights, none negative, with sum 1.
  std::array<float*, kMostListed> share{};
};

/// Of each camera's centre the coordinates of the view.
using CentersInView = std::array<std::array<float, 3>, kMostListed>;
std::array<float, 3> center_in_view(const ViewRays& rays, const std::array<float, 3>& center);

/// Camera j's parallax u_j at one pixel, in units of the view's picture plane at z = 1: how its image of the
/// surface is displaced where the proxy is wrong along the viewing ray `ray` (x, y, 1), but for a factor that
/// all cameras share. z, `normal` and `center` in the view's coordinates.
inline std::array<float, 2> parallax(const std::array<float, 2>& ray, float z,
                                     const std::array<float, 3>& normal, const std::array<float, 3>& center) {
  const float dx = ray[0] * z - center[0], dy = ray[1] * z - center[1], dz = z - center[2];
  const float facing = normal[0] * dx + normal[1] * dy + normal[2] * dz;
  const float least = -kGrazing * std::sqrt(dx * dx + dy * dy + dz * dz);
  const float scale = 1 / std::min(facing, least);
  return {(center[0] - ray[0] * center[2]) * scale, (center[1] - ray[1] * center[2]) * scale};
}

/// Where the proxy is wrong by some depth along the viewing ray, every camera's image of the surface is
/// displaced by its parallax u_j. Weights nearest to the angular ones under which these displacements cancel:
/// sum v_j u_j = 0. Where the angular weights do so already, or no camera has parallax, they stay.
void position_weights(const ViewRays& rays, const CentersInView& centers, const PositionRow& row);

/// Each camera's u_j at the pixels of a row, in px of the view; `row.share` is not looked at.
void parallaxes_of_row(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                       const std::array<float*, kMostListed>& x, const std::array<float*, kMostListed>& y);

/// Where each image is read for the pixels of a row.
struct FetchedRow {
  std::array<float*, kMostListed> pull{};              ///< only read: how much each counts by its angle
  std::array<float*, kMostListed> from_x{}, from_y{};  ///< px
};

/// Fields say two numbers an image and pixel. A proxy that is wrong by some depth along the viewing ray
/// explains them all by one: they read image i at depth (u_i - sum v_j u_j) from the pixel, and depth u_i is
/// where it should be read. Half of what differs from that is taken back: it is what calibration displaces,
/// but also what a flow makes up anew in every view (ADR 356). `row.share`: the position weights v.
void lean_on_depth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                   const FetchedRow& fetched);

/// Where images are read that stand beside their places by one displacement a pixel along their parallaxes,
/// which are scaled as Parallaxes are. `share`: how much each image counts; `displacement`: a list of the
/// row, px; `row.share` is not looked at.
void place_at_depth(const ViewRays& rays, const CentersInView& centers, const PositionRow& row,
                    std::span<const float> share, const float* displacement,
                    const std::array<float*, kMostListed>& from_x,
                    const std::array<float*, kMostListed>& from_y);

/// A row of vectors, and how far two of them are apart: adds to `sums`, `weight` times.
struct PlaneRow {
  const float *x, *y;
};
void add_distances(std::size_t count, float weight, const PlaneRow& a, const PlaneRow& b, float* sums);

}  // namespace floatstage::render::cpu
