#pragma once

#include <array>
#include <cstdint>

#include "render/cpu/raster_kernels.h"

// How much of a pixel a mesh covers, by samples; asked for a few pixels only.
namespace floatstage::render::cpu {

/// Where a pixel's samples lie, 1/256 px from its centre: four, of which no two share a row or a column.
/// render/gl/outline.cpp draws the same.
inline constexpr std::array<std::array<int, 2>, 4> kSamples = {{{-32, -96}, {96, -32}, {-96, 32}, {32, 96}}};

/// Rows [first, last) of a picture of a byte a pixel.
struct CoverRows {
  int width = 0, first = 0, last = 0;
  const std::uint8_t* wanted = nullptr;  ///< 0: the pixel is left alone
  std::uint8_t* covered = nullptr;       ///< a bit a sample: set where a triangle covers it
};

/// As draw_triangles(), of samples beside the centre.
void cover_triangles(const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
                     bool cull, const CoverRows& to);

}  // namespace floatstage::render::cpu
