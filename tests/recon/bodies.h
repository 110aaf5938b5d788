#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "core/mesh.h"

namespace floatstage::recon {

inline void append(Mesh& to, const Mesh& more) {
  const std::uint32_t first = static_cast<std::uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  for (std::uint32_t v : more.triangles) to.triangles.push_back(first + v);
}

/// Twelve triangles facing outwards.
inline Mesh cube(const Eigen::Vector3f& center, float side) {
  Mesh mesh;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3i corner(c & 1, (c >> 1) & 1, c >> 2);
    mesh.positions.push_back(center + side * (corner.cast<float>() - Eigen::Vector3f::Constant(0.5f)));
  }
  mesh.triangles = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  return mesh;
}

inline Mesh turned_inside_out(Mesh mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    std::swap(mesh.triangles[i + 1], mesh.triangles[i + 2]);
  return mesh;
}

/// A torus around z with `around` × `across` quads.
inline Mesh torus_mesh(float ring, float tube, int around = 24, int across = 12) {
  Mesh mesh;
  const auto at = [&](int u, int v) {
    return static_cast<std::uint32_t>((u % around) * across + v % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const float a = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(around);
      const float b = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(across);
      const float r = ring + tube * std::cos(b);
      mesh.positions.push_back({r * std::cos(a), r * std::sin(a), tube * std::sin(b)});
      for (std::uint32_t v :
           {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)})
        mesh.triangles.push_back(v);
    }
  }
  return mesh;
}

}  // namespace floatstage::recon
