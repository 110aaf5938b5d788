#pragma once

#include <array>

#include "render/cpu/position_kernels.h"
#include "render/cpu/projection.h"

namespace floatstage::render::cpu {

/// A camera that fades below it pulls nothing: no field towards it is needed.
inline constexpr float kLeastFade = 1e-4F;

/// How much each chosen camera counts over a row's pixels, in lists with sum 1.
struct PositionShares {
  std::array<float*, kMostListed> pull{};    ///< by its angle, visible or not
  std::array<float*, kMostListed> follow{};  ///< its idea of a position; 0 where that is faint
  /// The row that position weights were found on, where parallaxes are to cancel; its `share` is `follow`.
  PositionRow row{};
};

/// The shares of row y, in `memory`. `centers`: where they are to be such that parallaxes cancel; null: where
/// they are to be the angular ones.
PositionShares position_shares(const Projection& projection, int y, const CentersInView* centers,
                               RowMemory& memory);

/// The chosen cameras' centres.
CentersInView centers_in_view(const Projection& projection);

}  // namespace floatstage::render::cpu
