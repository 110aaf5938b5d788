#pragma once

#include "core/matte.h"
#include "core/mesh.h"
#include "core/rig.h"

namespace floatstage::recon {

/// The silhouette of a mesh in a camera's own, distorted pixels: 255 where the pixel's centre is covered,
/// else 0. Vertices go through the lens; the edges between them are drawn straight, which is true to a
/// fraction of a pixel for triangles of a few pixels. What lies behind the camera is cut off.
Matte mesh_mask(const RigCamera& camera, const Mesh& mesh);

}  // namespace floatstage::recon
