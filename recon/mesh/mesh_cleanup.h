#pragma once

#include "recon/octree/octree_surface.h"

namespace floatstage::recon {

struct CleanupOptions {
  double voxel = 0;           ///< metres
  double largest_move = 0.5;  ///< voxels: no vertex ends further from where it began; 0: no smoothing
  int threads = 0;
};

/// Makes a marching-cubes surface fit for use, with its half-edges in OpenMesh: edges much shorter than a
/// voxel are collapsed (they carry slivers and no shape), and positions are smoothed without shrinking
/// (Taubin, "A signal processing approach to fair surface design", 1995: a step in, a larger step out). Where
/// smoothing made triangles cross, vertices go back to where they were, and where even that is not enough, to
/// their safe positions: nothing crosses in the result. Positions are rounded to float. A closed manifold
/// stays one, with its shells and handles. The surface must be a closed manifold. The same bytes at any
/// thread count.
Surface clean_up(const Surface& surface, const CleanupOptions& options);

}  // namespace floatstage::recon
