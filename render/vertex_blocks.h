#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

namespace floatstage::render {

/// The vertices of a mesh in blocks, in their order, with a box around each: of a block that lies inside
/// something no vertex need be looked at. Meshes come in strips and cells, so a block's vertices are
/// neighbours; where they are not, all that is lost is time.
struct VertexBlocks {
  static constexpr std::size_t kVertices = 32;  ///< a block; the last may have fewer

  std::array<std::vector<float>, 3> low, high;  ///< by axis and block: its corners, metres
  Eigen::AlignedBox3f box;                      ///< of all; empty without vertices

  /// Replaces the blocks; storage is kept.
  void set(const std::vector<Eigen::Vector3f>& positions);
  std::size_t count() const { return low[0].size(); }
};

}  // namespace floatstage::render
