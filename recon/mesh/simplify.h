#pragma once

#include "core/mesh.h"
#include "core/result.h"

namespace floatstage::recon {

/// A mesh of at most `triangles` triangles, by collapsing the least important edges (quadric error metrics:
/// Garland and Heckbert 1997): vertices of the result are vertices of `mesh`, nothing folds over, shells and
/// handles stay. Holes are no obstacle. A mesh that is small enough comes back as it is; more are left where
/// no further one can go. BadData for a mesh with an edge of three triangles. Same input, same bytes.
Result<Mesh> simplified(const Mesh& mesh, int triangles);

}  // namespace floatstage::recon
