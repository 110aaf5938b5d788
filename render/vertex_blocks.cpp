#include "render/vertex_blocks.h"

#include <algorithm>

namespace floatstage::render {

void VertexBlocks::set(const std::vector<Eigen::Vector3f>& positions) {
  const std::size_t blocks = (positions.size() + kVertices - 1) / kVertices;
  for (auto* corners : {&low, &high})
    for (std::vector<float>& axis : *corners) axis.resize(blocks);
  box.setEmpty();
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::size_t begin = b * kVertices, end = std::min(begin + kVertices, positions.size());
    Eigen::AlignedBox3f around;
    for (std::size_t i = begin; i < end; ++i) around.extend(positions[i]);
    box.extend(around);
    for (int axis = 0; axis < 3; ++axis) {
      low[static_cast<std::size_t>(axis)][b] = around.min()[axis];
      high[static_cast<std::size_t>(axis)][b] = around.max()[axis];
    }
  }
}

}  // namespace floatstage::render
