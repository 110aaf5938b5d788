#include "core/mesh.h"

namespace floatstage {

Eigen::AlignedBox3f bounding_box(const Mesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.positions) box.extend(p);
  return box;
}

double signed_volume(const Mesh& mesh) {
  double six_volumes = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = mesh.positions[mesh.triangles[t]].cast<double>();
    const Eigen::Vector3d b = mesh.positions[mesh.triangles[t + 1]].cast<double>();
    const Eigen::Vector3d c = mesh.positions[mesh.triangles[t + 2]].cast<double>();
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

}  // namespace floatstage
