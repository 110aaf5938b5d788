#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

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
  /// World box to search, metres. Absent: the box of the intersection of all silhouettes' bounding pyramids.
  std::optional<Eigen::AlignedBox3d> volume;
  int resolution = 256;      ///< voxels along the longest side of the box
  double smoothing = 0.5;    ///< largest move of a vertex by smoothing, in voxels; 0: none
  int threads = 0;           ///< 0: one per core; the result is the same at any number
};

struct HullReport {
  Mesh mesh;                             ///< empty when no point of space is inside every silhouette
  double volume = 0;                     ///< m³
  std::vector<double> silhouette_iou;    ///< per camera: the mesh's silhouette against the matte; NaN for an empty matte
  Eigen::AlignedBox3d searched;          ///< metres
  double voxel = 0;                      ///< metres
  double seconds = 0;
};

/// The visual hull (Laurentini 1994): the largest body that projects into every silhouette. mattes[i] belongs to
/// rig.cameras[i] in its own, distorted pixels; an empty matte, and everything outside a camera's image, never
/// carves. Errors: InvalidArgument for unequal counts or sizes; BadData when no camera shows any subject
/// ("empty silhouette") or when the silhouettes bound nothing (all foreground) and no volume was given.
Result<HullReport> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options);

}  // namespace floatstage
