#pragma once

#include <vector>

#include "core/result.h"
#include "core/view.h"
#include "render/vertex_blocks.h"

namespace floatstage::render {

/// A rectangle of a view, px. May reach beyond the view on every side.
struct Window {
  int x = 0, y = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
};

/// InvalidArgument with a sentence for a view that cannot be drawn.
Result<void> check(const View& view);

/// The part of a view that a mesh covers, grown by `margin` px, cut at the view's border plus `margin`, with
/// corners on multiples of 16 px (so that coarse levels of the flow see the same grid from view to view).
/// Projects all vertices: the reference of the one below.
Window window_of(const View& view, const std::vector<Eigen::Vector3f>& positions, int margin);

/// The same window from the vertices of those `blocks` that reach beyond what the others cover.
Window window_of(const View& view, const std::vector<Eigen::Vector3f>& positions, const VertexBlocks& blocks,
                 int margin);

}  // namespace floatstage::render
