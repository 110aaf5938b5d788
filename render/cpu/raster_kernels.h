#pragma once

#include <cstdint>

// The rasteriser's inner loop.
namespace floatstage::render::cpu {

/// A corner on the screen: 1/256 px from the first pixel's centre.
struct ScreenVertex {
  std::int32_t x = 0, y = 0;
  float inverse_z = 0;
};

/// Rows [first, last) of a picture of 1/z, and of the triangle that is seen (may be null).
struct RasterRows {
  int width = 0, first = 0, last = 0;
  float* inverse_z = nullptr;
  std::uint32_t* triangle = nullptr;
};

/// Draws `count` triangles, three corners each, in their order: 1/z where it is larger than what is there,
/// and `first_index` + the triangle's place. `cull` leaves out those that do not turn counter-clockwise on
/// the screen (y pointing down). Coordinates below 2^22.
void draw_triangles(const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
                    std::uint32_t first_index, bool cull, const RasterRows& to);

}  // namespace floatstage::render::cpu
