#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"

namespace floatstage::matting {

/// The picture at a smaller size, by area means; the picture itself when the size fits.
Image shrunk(const Image& picture, int width, int height);

/// Of each pixel of an RGB picture how much of edges lies between it and the picture's border on the way that
/// crosses least: the geodesic distance of Y. Wei, F. Wen, W. Zhu and J. Sun, "Geodesic Saliency Using
/// Background Priors", ECCV 2012, where what is no steeper than light or noise costs nothing. Cloth that
/// is lit unevenly lies near the border by that, a subject before it far. In 8-bit steps, summed over
/// channels.
std::vector<float> edges_to_border(const Image& picture);

/// The standard deviation of a picture's noise, 8-bit steps summed over channels: from the median difference
/// of neighbours, which shows noise wherever more than half of the picture is calm. At least 1.
double noise_of(const Image& picture);

/// What is known of a pixel when a picture is cut.
enum class Certain : std::uint8_t { No, Backdrop, Subject };

/// The cheapest split into subject (255) and background (0): the sum of the odds of pixels on the wrong side
/// plus, for 8-neighbours on different sides, `smooth` times how alike they look, against the mean contrast
/// (Boykov, Jolly 2001). Exact: a minimum cut (core/graph_cut.h). `odds`: log of how much likelier subject
/// is than background. `certain`: empty, or of every pixel. `empty_stage`: empty, or what the camera sees
/// without a subject, RGB of the picture's size: edges are then those of what changed, so that the stage's
/// own are none, and skin before a wall of its colour has some (J. Sun, W. Zhang, X. Tang and H.-Y. Shum,
/// "Background Cut", ECCV 2006, attenuate the former). `shadow`: empty, or of every pixel, not 0 where the
/// stage is supposed to look as the picture does: edges between two such are the picture's. Deterministic.
Image cut_view(const Image& picture, std::span<const float> odds, std::span<const Certain> certain,
               double smooth, const Image& empty_stage = {}, std::span<const std::uint8_t> shadow = {});

}  // namespace floatstage::matting
