#pragma once

#include <array>
#include <cstdint>

#include "render/camera_choice.h"

// Inner loops that carry intermediate images along their combined warps (Eq. 11.2). Formulas:
// render/gl/shaders/float.comp.
namespace floatstage::render::cpu {

/// Planes of the window that one intermediate image is read from.
struct WarpSource {
  int width = 0, height = 0;
  const float* inverse_z = nullptr;      ///< 0 off the proxy
  const std::uint8_t* own = nullptr;     ///< a bit an image: the colour there is its own; 0 off the proxy
  const std::uint32_t* image = nullptr;  ///< RGBA bytes; good on the proxy
  const float* soft = nullptr;           ///< soft visibility, 0 off the proxy
  int slot = 0;                          ///< whose bit of `own`
  float tolerance = 0;                   ///< metres by which a connected surface may jump over a pixel
};

/// The flow fields from this image to the others, and what draws them.
struct WarpFields {
  int count = 0;
  std::array<const float*, kMostListed> uv{};     ///< u, v interleaved
  std::array<const float*, kMostListed> pulls{};  ///< list: how much each counts at a pixel
  int width = 0, height = 0;
  float shrink = 1;  ///< px of the window a px of the fields
};

/// A row's list of pixels, and where image points that land on them come from.
struct WarpedRow {
  int count = 0;
  const float* x = nullptr;  ///< px
  float y = 0;
  float *from_x = nullptr, *from_y = nullptr;  ///< px
  float* inverse_z = nullptr;                  ///< there
  std::int32_t* direct = nullptr;  ///< 1: own colour on a connected surface, to be read from the photograph
  float* seen = nullptr;           ///< soft visibility there
};

/// I's point p lands at p + W(p): finds the one that lands on each pixel, by iteration.
void invert_warps(const WarpFields& fields, const WarpedRow& row);

/// What is at those points.
void look_up(const WarpSource& source, const WarpedRow& row);

/// Colours (r g b a, 0…255) from the intermediate image at the pixels whose `direct` is 0; where it has none,
/// from the pixel itself, which then is `from`.
void borrow_colors(const WarpSource& source, const WarpedRow& row, float* rgba);

}  // namespace floatstage::render::cpu
