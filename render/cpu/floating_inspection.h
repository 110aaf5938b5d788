#pragma once

#include <array>

#include "render/cpu/position_shares.h"
#include "render/inspection.h"
#include "render/pairwise_flows.h"

namespace floatstage::render::cpu {

/// What the floating renderer has of a row once its images are warped: lists, one an image.
struct FloatedRow {
  const PositionShares& share;
  std::array<float*, kMostListed> rgba{}, used{};      ///< warped colours, and how much they count
  std::array<float*, kMostListed> from_x{}, from_y{};  ///< where in the image they come from, px
  const float* mean = nullptr;                         ///< the view: three floats a pixel
  /// By depth (Alignment::Depth), how far it is believed: ProjectedImages' plane of this width; null: by
  /// fields.
  const std::uint8_t* believed = nullptr;
  int width = 0;
};

/// Whether it is float_intermediate() that draws it.
bool is_floating_intermediate(RenderOutput output);

/// Writes one row of an intermediate that only "floating" has: rgb, 0…255, three floats a pixel.
void float_intermediate(const Projection& projection, const PairwiseFlows& flows,
                        const RendererOptions& options, const ShownSlots& shown, int y, const FloatedRow& row,
                        float* rgb, RowMemory& memory);

}  // namespace floatstage::render::cpu
