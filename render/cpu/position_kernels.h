#pragma once

#include <array>

#include "render/camera_choice.h"
#include "render/cpu/photo_kernels.h"

// How much each camera's idea of a position counts, over lists of pixels. Formulas:
// render/gl/shaders/positions.glsl; derivation: docs/algorithms/floating-textures.md.
namespace floatstage::render::cpu {

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
std::array<float, 3> center_in_view(const ViewRays& rays, const PhotoCamera& camera);

/// Where the proxy is wrong by some depth along the viewing ray, every camera's image of the surface is
/// displaced by its parallax u_j. Weights nearest to the angular ones under which these displacements cancel:
/// sum v_j u_j = 0. Where the angular weights do so already, or no camera has parallax, they stay.
void position_weights(const ViewRays& rays, const CentersInView& centers, const PositionRow& row);

}  // namespace floatstage::render::cpu
