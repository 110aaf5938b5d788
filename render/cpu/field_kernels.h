#pragma once

#include <array>
#include <cstdint>

#include "render/camera_choice.h"
#include "render/cpu/photo_kernels.h"

// Inner loop of floating by precomputed fields (Eq. 11.4). The twin of render/gl/shaders/static.comp.
namespace floatstage::render::cpu {

/// The fields of one photograph to others, and what draws them. All on one grid.
struct FieldPulls {
  std::array<float, 4> place{};  ///< of the grid, see CameraField
  int width = 0, height = 0;
  int count = 0;  ///< of fields; 0: nothing moves
  std::array<const std::int16_t*, kMostListed> uv{};
  std::array<const float*, kMostListed> pulls{};  ///< list: how much each counts at a pixel
};

/// As project_points(), but where the photograph shows what the fields move onto the points. `moved_x` and
/// `moved_y`: by how many pixels of the grid that is.
void float_points(const PhotoCamera& camera, const ViewRays& rays, const PixelList& points,
                  const FieldPulls& fields, float* u, float* v, std::int32_t* inside, float* moved_x,
                  float* moved_y);

}  // namespace floatstage::render::cpu
