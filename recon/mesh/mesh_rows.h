#pragma once

#include <cstdint>

#include "core/matte.h"
#include "core/mesh.h"
#include "core/rig.h"

namespace floatstage::recon {

/// Pixels of a mesh's silhouette against a matte (half opacity), in the rows that were looked at.
struct RowCounts {
  std::int64_t matte = 0, mesh = 0, both = 0;
  /// Intersection over union; 1 when both are empty.
  double iou() const {
    const std::int64_t either = matte + mesh - both;
    return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1;
  }
};

/// Compares every `step`-th row, beginning with the middle one of the first `step`: with a step of 4, IoU of
/// figures comes within some thousandths of iou() of mesh_mask(). The mesh is closed
/// and outward: only its front is drawn. Any thread.
RowCounts compare_rows(const RigCamera& camera, const Mesh& mesh, const Matte& matte, int step);

}  // namespace floatstage::recon
