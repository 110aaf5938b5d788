#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/matte.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage {

enum class HullMethod {
  Octree,  ///< carving of an octree and an iso-surface: slow, soft, sturdy; the reference
};

struct HullOptions {
  HullMethod method = HullMethod::Octree;
  /// World box to search, metres; the hull is cut off at its sides. Absent: the box of the intersection of
  /// all silhouettes' bounding pyramids, shrunk to what the silhouettes leave of it.
  std::optional<Eigen::AlignedBox3d> volume = {};
  int resolution = 256;    ///< voxels along the longest side of the box, 8 … 1024
  double smoothing = 0.5;  ///< largest move of a vertex by smoothing, in voxels; 0: none
  int threads = 0;         ///< 0: one per core; the result is the same at any number
};

/// Every number in range; the sentence says which is not.
Result<void> check(const HullOptions& options);

struct HullReport {
  Mesh mesh;          ///< empty when no point of space is inside every silhouette
  double volume = 0;  ///< m³
  std::vector<double>
      silhouette_iou;  ///< per camera: the mesh's silhouette against the matte; NaN for an empty matte
  Eigen::AlignedBox3d searched;  ///< metres
  double voxel = 0;              ///< metres
  double seconds = 0;
  /// What a person should know, a sentence each: cameras that saw only background, an empty hull and why.
  std::vector<std::string> remarks;
};

/// The visual hull (Laurentini 1994): the largest body that projects into every silhouette. mattes[i] belongs
/// to rig.cameras[i] in its own, distorted pixels; half opacity is the silhouette's edge.
///
/// An empty matte, and everything outside a camera's image, never carves: it is unknown. A camera that sees
/// only background carves all that it sees, which usually leaves nothing: that is an empty mesh and a remark,
/// no error. Space that no camera sees is not hull either: nothing bears witness for it. Where a subject is
/// cut off by an image's border, other cameras or options.volume must bound it.
///
/// The mesh is closed, manifold and oriented. `options.threads` threads work inside; inputs are only read.
/// Errors: InvalidArgument for unequal counts or sizes and for options out of range; BadData for a rig that
/// does not pass check(), when no camera shows any subject ("empty silhouette"), and when the silhouettes
/// bound nothing (all foreground) and no volume was given.
Result<HullReport> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options);

}  // namespace floatstage
