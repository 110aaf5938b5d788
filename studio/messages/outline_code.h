#pragma once

#include <string>
#include <string_view>

#include "core/result.h"
#include "core/silhouette.h"

namespace floatstage::studio::wire {

/// Points on a grid of this many steps a pixel. Two edges that recon keeps kOutlineGap (0.01 px) apart are
/// still apart on it: rounding moves a point by at most 0.0028 px.
inline constexpr int kOutlineSteps = 256;

/// No point lies further from the picture's corner than this, px.
inline constexpr double kFurthestPoint = 1 << 20;

/// No outline has more points: seven times what recon makes of the worst matte.
inline constexpr std::size_t kMostOutlinePoints = 1 << 17;

/// Polygons as differences from point to point, short numbers for short edges: about four bytes a point.
/// InvalidArgument for a point that is no number or too far away, or a polygon of fewer than three.
Result<std::string> encode_outline_points(const Silhouette& outline);
Result<Silhouette> decode_outline_points(std::string_view code);

}  // namespace floatstage::studio::wire
