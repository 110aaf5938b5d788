#include "recon/mesh/mesh_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "recon/mesh/mesh_mask.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

void count_row(const std::uint8_t* mesh, const std::uint8_t* matte, int width, RowCounts& out) {
  int in_mesh = 0, in_matte = 0, in_both = 0;
  for (int x = 0; x < width; ++x) {
    const int a = mesh[x] >> 7, b = matte[x] >> 7;
    in_mesh += a;
    in_matte += b;
    in_both += a & b;
  }
  out.mesh += in_mesh;
  out.matte += in_matte;
  out.both += in_both;
}

/// The rows that are looked at, one below the other.
struct Rows {
  int width, step, first, count;
  std::vector<std::uint8_t> pixels;

  void fill(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    const double low = std::min({a.y(), b.y(), c.y()}), high = std::max({a.y(), b.y(), c.y()});
    const double pitch = 1.0 / step;
    int row = std::max(0, static_cast<int>(std::ceil((low - 0.5 - first) * pitch)));
    for (; row < count && first + row * step + 0.5 <= high; ++row) {
      const double y = first + row * step + 0.5;
      double left = 1e9, right = -1e9;
      const auto cross = [&](const Vector2d& p, const Vector2d& q) {
        if ((p.y() < y && q.y() < y) || (p.y() > y && q.y() > y)) return;
        const double x = p.y() == q.y() ? p.x() : p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x());
        left = std::min(left, x);
        right = std::max(right, x);
      };
      cross(a, b);
      cross(b, c);
      cross(c, a);
      const int x0 = static_cast<int>(std::ceil(std::clamp(left - 0.5, 0.0, static_cast<double>(width))));
      const int x1 = static_cast<int>(std::floor(std::clamp(right - 0.5, -1.0, width - 1.0)));
      if (x0 > x1) continue;
      std::uint8_t* const line =
          pixels.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
      std::fill(line + x0, line + x1 + 1, std::uint8_t{255});
    }
  }
};

}  // namespace

RowCounts compare_rows(const RigCamera& camera, const Mesh& mesh, const Matte& matte, int step) {
  const int first = step / 2, width = matte.width;
  Rows rows{width, step, first, std::max(0, (matte.height - first + step - 1) / step), {}};
  rows.pixels.resize(static_cast<std::size_t>(rows.count) * static_cast<std::size_t>(width));
  RowCounts out;
  std::vector<Vector2d> pixels(mesh.positions.size());
  for (std::size_t v = 0; v < pixels.size(); ++v) {
    const auto pixel = project(camera.model, camera.cam_from_world * mesh.positions[v].cast<double>());
    // Far outside, filling clamps; what is behind or beside the camera needs cutting, which takes time.
    if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) {
      const Matte mask = mesh_mask(camera, mesh);
      for (int r = 0; r < rows.count; ++r)
        count_row(mask.row(first + r * step), matte.row(first + r * step), width, out);
      return out;
    }
    pixels[v] = *pixel;
  }
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Vector2d &a = pixels[mesh.triangles[t]], &b = pixels[mesh.triangles[t + 1]],
                   &c = pixels[mesh.triangles[t + 2]];
    const bool front = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()) < 0;
    if (front) rows.fill(a, b, c);
  }
  for (int r = 0; r < rows.count; ++r)
    count_row(rows.pixels.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(width),
              matte.row(first + r * step), width, out);
  return out;
}

}  // namespace floatstage::recon
