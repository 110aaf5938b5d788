#pragma once

#include <cstddef>
#include <span>

#include "recon/mesh/half_edges.h"
#include "recon/mesh/reprojection_bound.h"
#include "recon/mesh/slivers.h"

namespace floatstage::recon {

/// Smooths without shrinking and without rounding ridges off (Sun, Rosin, Martin and Langbein, "Fast and
/// effective feature-preserving mesh denoising", 2007): every round averages the triangles' normals with
/// those of neighbours that nearly agree, weighted by area, then moves vertices towards the planes that the
/// new normals ask for. Positions are never averaged and no triangle turns away from its new normal: those of
/// a hull are long and thin, and fold easily. `known` holds normals for the slivers, and afterwards those
/// that were asked for. No vertex leaves what `bound` allows; vertex v is names[v] there. The mesh has no
/// deleted elements. The same bytes at any thread count.
void smooth_within(HalfEdges& mesh, FaceNormals known, const ReprojectionBound& bound,
                   std::span<const std::size_t> names, int rounds, int threads);

}  // namespace floatstage::recon
