#pragma once

#include <string>

#include "core/mesh.h"

namespace floatstage {

/// What kind of surface a mesh is.
struct MeshCheck {
  bool watertight = false;    ///< every edge has exactly two triangles
  bool manifold = false;      ///< watertight, and the triangles at every vertex form one fan
  bool oriented = false;      ///< neighbours agree on the outside
  bool outward = false;       ///< every shell that is not inside another has positive volume
  bool self_intersecting = false;  ///< two triangles that share no vertex cross
  int shells = 0;             ///< connected components
  int degenerate = 0;         ///< triangles without area
  int genus = 0;              ///< sum over shells, when manifold
  double volume = 0;          ///< m³

  bool good() const { return watertight && manifold && oriented && outward && !self_intersecting; }
  std::string summary() const;  ///< one sentence
};

MeshCheck check_mesh(const Mesh& mesh);

}  // namespace floatstage
