#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace floatstage {

/// An indexed triangle mesh: metres, three indices a triangle, counter-clockwise seen from outside.
struct Mesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::uint32_t> triangles;

  bool empty() const { return triangles.empty(); }
  std::size_t triangle_count() const { return triangles.size() / 3; }
};

Eigen::AlignedBox3f bounding_box(const Mesh& mesh);

/// Enclosed volume in m³, positive for outward orientation (sum of signed tetrahedra, in double).
double signed_volume(const Mesh& mesh);

}  // namespace floatstage
