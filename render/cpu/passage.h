#pragma once

#include <array>
#include <cstddef>

#include "render/cpu/photo_kernels.h"

namespace floatstage::render::cpu {

/// From pixels of one view's window to those of another's.
class Passage {
 public:
  struct Point {
    float x, y, z;  // px, and depth in that view
  };

  Passage(const ViewRays& from, const ViewRays& to) : from_(from), to_(to) {
    const std::array<float, 9>&a = to.world_from_view, &b = from.world_from_view;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 3; ++c) turn_[3 * r + c] += a[3 * k + r] * b[3 * k + c];
        move_[r] += a[3 * k + r] * (from.eye[k] - to.eye[k]);
      }
  }

  Point of(float x, float y, float z) const {
    const float ry = (y - from_.cy) * from_.inverse_fy,
                rx = (x - from_.cx - from_.skew * ry) * from_.inverse_fx;
    std::array<float, 3> at = move_;
    for (std::size_t r = 0; r < 3; ++r)
      at[r] += z * (turn_[3 * r] * rx + turn_[3 * r + 1] * ry + turn_[3 * r + 2]);
    const float px = at[0] / at[2], py = at[1] / at[2];
    return {px / to_.inverse_fx + to_.skew * py + to_.cx, py / to_.inverse_fy + to_.cy, at[2]};
  }

 private:
  const ViewRays &from_, &to_;
  std::array<float, 9> turn_{};
  std::array<float, 3> move_{};
};

/// The surface as a picture shows it.
struct SeenSurface {
  const float* inverse_z;
  int width, height;

  /// 0: nothing there.
  float z_at(float x, float y) const {
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(width) && y < static_cast<float>(height))) return 0;
    const float inverse = inverse_z[static_cast<std::ptrdiff_t>(y) * width + static_cast<std::ptrdiff_t>(x)];
    return inverse > 0 ? 1 / inverse : 0;
  }
};

}  // namespace floatstage::render::cpu
