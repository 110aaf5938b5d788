#pragma once

#include <cstdint>
#include <vector>

#include "core/matte.h"
#include "core/mesh.h"
#include "core/rig.h"

namespace floatstage::recon {

/// A mesh whose silhouette several cameras are asked for. Which triangles meet at each edge is found once;
/// a camera then draws only the edges between its front and its back, row by row, and fills between them.
/// Where every edge has as many triangles on one side as on the other, no point is behind the camera and no
/// corner millions of pixels away, that is mesh_mask(), but for centres that an edge runs through to the last
/// digit; else mesh_mask() is what draws. Any thread.
class MeshSilhouettes {
 public:
  MeshSilhouettes() = default;  ///< of nothing
  /// Some milliseconds for 60,000 triangles.
  explicit MeshSilhouettes(Mesh mesh);

  bool empty() const { return mesh_.empty(); }

  /// As mesh_mask(): 255 where the pixel's centre is covered, else 0.
  Matte of(const RigCamera& camera) const;
  /// Intersection over union with a matte of the camera's size, at half opacity, in every `step`-th row,
  /// beginning with the middle one of the first `step`; 1 when both are empty there. A step of 4 tells nearly
  /// the same as all rows.
  double iou(const RigCamera& camera, const Matte& matte, int step) const;

 private:
  struct Edge {
    std::uint32_t from, to;                       ///< vertices
    std::uint32_t along_triangle, back_triangle;  ///< that run through it in this direction, and the other
  };
  class Windings;
  bool draw(const RigCamera& camera, Windings& windings) const;

  Mesh mesh_;
  std::vector<Edge> edges_;
  bool closed_ = false;
};

}  // namespace floatstage::recon
