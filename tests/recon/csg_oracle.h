#pragma once

#include <span>

#include "recon/exact/exact_views.h"

namespace floatstage::recon {

/// The volume of all points that lie inside all of the cones, by general constructive solid geometry with
/// exact numbers (CGAL's corefinement, ADR 0077): every polygon becomes a closed pyramid from its camera's
/// centre to `far` units of depth, which must be beyond the hull; outlines are intersected, then holes taken
/// away. For small sets: it takes seconds. Views of one outline each, `beyond_counts` is not meant for it.
/// Negative when CGAL gave up.
double volume_by_csg(std::span<const ConeView> views, double far);

}  // namespace floatstage::recon
