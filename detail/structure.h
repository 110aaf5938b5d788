#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "detail/float_picture.h"

namespace floatstage::detail {

/// An edge that crosses the seam in both pictures: where in the parent, and where in the child.
struct EdgePair {
  Eigen::Vector2d parent, child;
};

/// What moves a child's edges onto its parent's (thesis 4.3.2).
struct Structure {
  std::vector<EdgePair> on_seam;          ///< matched edges on the seam, to a fraction of a pixel
  std::vector<EdgePair> along_edges;      ///< traced from there into the child
  std::vector<std::uint8_t> edges_child;  ///< 1: Canny's edges
  std::vector<std::uint8_t> edges_parent;
  LightPicture displacement;  ///< x and y in the first two numbers: the child's place of a pixel, less it
};

/// `child`, `parent`: of one size, tones matched, equally sharp; `seam`: 1 where the child is used. Edges
/// along the seam are matched in order (dynamic programming, Eq. 4.3) within `reach` px and where they rise
/// the same way; between them displacements are interpolated along the seam, farther than a tenth of its
/// length from any they are zero; edges are traced inwards for `trace` px; the rest is diffused (Eq. 4.4).
/// Without a matched edge nothing moves.
Structure align_structure(const LightPicture& child, const LightPicture& parent,
                          const std::vector<std::uint8_t>& seam, double reach = 12, int trace = 12);

/// The child as it is after its pixels have moved.
LightPicture displaced(const LightPicture& child, const LightPicture& displacement);

}  // namespace floatstage::detail
