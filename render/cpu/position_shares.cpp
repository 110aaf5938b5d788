#include "render/cpu/position_shares.h"

#include <algorithm>
#include <cmath>

namespace floatstage::render::cpu {

PositionShares position_shares(const Projection& projection, int y, const CentersInView* centers,
                               RowMemory& memory) {
  const Covered::Row& row = projection.covered().rows[static_cast<std::size_t>(y)];
  const auto pixels = static_cast<std::size_t>(row.count);
  const std::size_t count = projection.choice().chosen;
  const float even = 1 / static_cast<float>(count);
  PositionShares shares;
  float* total = memory.floats(pixels);
  std::fill_n(total, pixels, 0.F);
  for (std::size_t i = 0; i < count; ++i) {
    const float fade = projection.choice().fade[i], share = fade < kLeastFade ? 0 : fade;
    const float* angular = projection.angular(i) + row.list;
    shares.pull[i] = memory.floats(pixels);
    shares.follow[i] = memory.floats(pixels);
    for (std::size_t k = 0; k < pixels; ++k) {
      shares.pull[i][k] = share * std::abs(angular[k]);
      total[k] += shares.pull[i][k];
    }
  }
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < pixels; ++k)
      shares.follow[i][k] = shares.pull[i][k] = total[k] > 0 ? shares.pull[i][k] / total[k] : even;
  if (centers != nullptr) {
    float *nx = memory.floats(pixels), *ny = memory.floats(pixels), *nz = memory.floats(pixels);
    projection.write_normals(y, nx, ny, nz);
    shares.row = {row.count,
                  static_cast<int>(count),
                  projection.covered().x.data() + row.list,
                  static_cast<float>(y) + 0.5F,
                  projection.covered().inverse_z.data() + row.list,
                  {nx, ny, nz},
                  shares.follow};
    position_weights(projection.rays(), *centers, shares.row);
  }
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < pixels; ++k)
      if (shares.follow[i][k] < kFaintShare) shares.follow[i][k] = 0;
  return shares;
}

CentersInView centers_in_view(const Projection& projection) {
  CentersInView centers{};
  for (std::size_t i = 0; i < projection.choice().chosen; ++i)
    centers[i] = center_in_view(projection.rays(), projection.camera(i).center);
  return centers;
}

}  // namespace floatstage::render::cpu
