#pragma once

#include "recon/mesh/half_edges.h"
#include "recon/mesh/slivers.h"

namespace floatstage::recon {

/// Collapses the least important edges (quadric error metrics: Garland and Heckbert, "Surface simplification
/// using quadric error metrics", 1997) until `triangles` are left or none may go: nothing folds over, new
/// slivers only where nothing else is left to collapse, shells and handles stay. Vertices of the result are
/// vertices of the input. Collapsed elements are swept up.
void decimate(HalfEdges& mesh, FaceNormals normals, std::size_t triangles);

}  // namespace floatstage::recon
