#pragma once

#include "tests/render/stage.h"
#include "tests/support/camera_grids.h"

namespace floatstage::render {

/// A wall across y at `y` metres, before the cameras of camera_wall().
inline Mesh wall_at(float y, float half_width = 0.45F, float half_height = 0.35F, int pieces = 8) {
  Mesh mesh;
  for (int r = 0; r <= pieces; ++r)
    for (int c = 0; c <= pieces; ++c)
      mesh.positions.emplace_back(half_width * (2 * static_cast<float>(c) / static_cast<float>(pieces) - 1),
                                  y,
                                  half_height * (1 - 2 * static_cast<float>(r) / static_cast<float>(pieces)));
  auto at = [&](int r, int c) { return static_cast<std::uint32_t>(r * (pieces + 1) + c); };
  for (int r = 0; r < pieces; ++r)
    for (int c = 0; c < pieces; ++c)
      mesh.triangles.insert(mesh.triangles.end(), {at(r, c), at(r + 1, c), at(r, c + 1), at(r, c + 1),
                                                   at(r + 1, c), at(r + 1, c + 1)});
  return mesh;
}

/// A grid of cameras before a wall whose proxy stands `off` metres behind it, at y = 0.
inline Stage before_a_wall(int rows, int columns, float off = 0.02F) {
  return photographed(camera_wall(rows, columns), wall_at(-off), wall_at(0), false);
}

/// From the cameras' plane, or `back` metres behind it.
inline View view_from(double x, double z, double back = 0) {
  View view;
  view.model = small_camera();
  view.view_from_world = look_at({x, -1 - back, z}, {x, 0, z}, {0, 0, 1});
  return view;
}

/// Where a view's ray through the middle of a pixel meets the proxy at y = 0; and its direction, of length 1.
struct WallPoint {
  Eigen::Vector3d place, way;
};
inline WallPoint on_wall(const View& view, int x, int y) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  const Eigen::Vector3d way =
      (view.view_from_world.rotation.conjugate() * *unproject(view.model, {x + 0.5, y + 0.5})).normalized();
  return {eye - way * (eye.y() / way.y()), way};
}

/// A picture's colour at a point, bilinear, the border repeated.
inline Eigen::Array3d read(const Image& rgb, const Eigen::Vector2d& p) {
  const double x = std::clamp(p.x() - 0.5, 0.0, rgb.width - 1.0),
               y = std::clamp(p.y() - 0.5, 0.0, rgb.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), rgb.width - 2),
            y0 = std::min(static_cast<int>(y), rgb.height - 2);
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const int u = x0 + (k & 1), v = y0 + (k >> 1);
    const double w = (1 - std::abs(x - u)) * (1 - std::abs(y - v));
    for (int c = 0; c < 3; ++c) sum[c] += w * rgb.at(u, v)[c];
  }
  return sum;
}

inline void put(const Eigen::Array3d& color, std::uint8_t* rgba) {
  for (int c = 0; c < 3; ++c)
    rgba[c] = static_cast<std::uint8_t>(std::lround(std::clamp(color[c], 0.0, 255.0)));
  rgba[3] = 255;
}

}  // namespace floatstage::render
