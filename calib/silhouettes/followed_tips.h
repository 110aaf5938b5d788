#pragma once

#include <span>
#include <vector>

#include "calib/silhouettes/tangencies.h"
#include "core/rig.h"
#include "core/silhouette.h"

namespace floatstage::calib {

/// Which end of a pencil of planes: the smallest angles, or the largest.
enum class PencilEnd { Smallest, Largest };

/// Places where planes of the pencil touch an outline from outside, the outermost and all others that bulge
/// out (hands, elbows, knees), followed from picture to picture. For each place that was seen in ten pictures
/// at least its angle in every one of them, in `angle_per_pixel`; NaN where it was not seen. What is cut by
/// the border is left out. `frames[k][camera]` are the k-th pictures of the rig's cameras.
std::vector<std::vector<double>> followed_tips(const PlanePencil& pencil, const RigCamera& rig_camera,
                                               std::size_t camera, PencilEnd end,
                                               std::span<const std::vector<Silhouette>> frames,
                                               double angle_per_pixel);

}  // namespace floatstage::calib
