#pragma once

#include <span>

#include "recon/exact/exact_views.h"

namespace floatstage::recon {

/// The volume of all points that lie inside at least `votes` of the cones, by a way that has nothing in
/// common with the engine: every silhouette is a signed sum of triangles, every triangle's cone is three
/// half-spaces, and the volume of an intersection of half-spaces comes from clipping a box. Exact up to
/// rounding; exponential in the number of views. The part of space beyond 100 units from the origin is left
/// out.
double volume_by_clipping(std::span<const ConeView> views, int votes);

}  // namespace floatstage::recon
