#pragma once

#include <string>

#include "core/mesh.h"

namespace floatstage::recon {

/// What kind of surface a mesh is.
struct MeshCheck {
  bool watertight = false;  ///< every edge has exactly two triangles
  bool manifold = false;    ///< watertight, and the triangles at every vertex form one fan
  bool oriented = false;    ///< neighbours agree on the outside
  /// Every shell encloses positive volume, cavities (shells at odd depth inside others) negative.
  bool outward = false;
  bool self_intersecting = false;  ///< two triangles that share no vertex cross
  int shells = 0;                  ///< components connected through common vertices
  int degenerate = 0;              ///< triangles without area
  int genus = 0;                   ///< sum over shells, when manifold
  double volume = 0;               ///< m³

  bool good() const { return watertight && manifold && oriented && outward && !self_intersecting; }
  std::string summary() const;  ///< one sentence
};

/// Looks at every edge, vertex fan and pair of near triangles. A mesh without triangles is watertight,
/// manifold, oriented and outward, with 0 shells. Vertices are told apart by index, not by place; unused ones
/// are ignored. An index beyond the positions makes the mesh neither watertight nor anything else. Any
/// thread; only reads.
MeshCheck check_mesh(const Mesh& mesh);

}  // namespace floatstage::recon
