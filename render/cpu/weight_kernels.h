#pragma once

#include <array>
#include <cstdint>

#include "render/camera_choice.h"
#include "render/enough.h"

// Inner loops of soft visibility (Eq. 11.5) and of the blending weights. Lists are padded to Covered::kAlign.
// Formulas: render/gl/shaders/soft_rows.comp and weights.comp.
namespace floatstage::render::cpu {

inline constexpr float kStandIn = 1e-3F;  ///< mattes of cameras beyond the chosen ones count so much
inline constexpr std::int16_t kNoneNear = 1 << 14;  ///< a squared distance beyond every radius

/// A row's pixels that are hidden, a bit a camera, and most of whose nine neighbours (with themselves, and
/// with the rows above and below) are, too: `hidden` gets bits of `here`. All of `width` bytes, none the
/// same.
void without_specks(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int width,
                    std::uint8_t* hidden);

/// The distance filter's first pass: per pixel of a row the squared distance along it to the next pixel whose
/// bit `slot` of `hidden` is set, kNoneNear where there is none within `radius` px. `scratch` holds 2 *
/// (width + 2 * radius + 64) bytes. False, and nothing is written, when there is none in the row.
bool row_distances(const std::uint8_t* hidden, int width, int slot, int radius, std::uint8_t* scratch,
                   std::int16_t* squares);

/// The second: of `count` pixels the distance to the next hidden one in any of the rows, as a share of the
/// radius, at most 1. `rows[i]` are first-pass rows at the first pixel, `offsets[i]` their squared distances
/// along y.
void soft_shares(const std::int16_t* const* rows, const std::int16_t* offsets, int row_count, float radius,
                 int count, float* shares);

/// A row's list of pixels with all that weights are made of.
struct WeightRow {
  int count = 0, listed = 0;
  bool one_camera = false;
  std::array<const float*, kMostListed> angular{};
  std::array<float*, kMostListed> soft{};  ///< in: soft_shares(); out: 0 where the camera sees nothing
  std::array<float*, kMostListed> weight{};
  std::array<float, kMostListed> fade{}, stand_in_fade{};
  const std::uint8_t* visible = nullptr;  ///< a bit a camera
};
void blending_weights(const WeightRow& row);

}  // namespace floatstage::render::cpu
