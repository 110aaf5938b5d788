#include "render/light_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace floatstage::render {
namespace {

constexpr float kParallel = 1e-6F;  // a ray along the plane meets it at its side

std::array<float, 3> floats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

float dot(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The last place that is not behind `at` and has a next one; and where `at` lies between the two.
int between(const std::vector<float>& places, float at, float& share) {
  std::size_t i = 0;
  while (i + 2 < places.size() && places[i + 1] <= at) ++i;
  share = std::clamp((at - places[i]) / (places[i + 1] - places[i]), 0.F, 1.F);
  return static_cast<int>(i);
}

}  // namespace

LightFieldPlane::LightFieldPlane(const CameraGrid& grid, const Eigen::Vector3d& eye)
    : normal(floats(grid.normal())),
      right(floats(grid.right)),
      down(floats(grid.down)),
      cameras(grid.cameras) {
  const Eigen::Vector3d from = eye - grid.origin;
  height = static_cast<float>(grid.normal().dot(from));
  eye_x = static_cast<float>(grid.right.dot(from));
  eye_y = static_cast<float>(grid.down.dot(from));
  for (double v : grid.x) x.push_back(static_cast<float>(v));
  for (double v : grid.y) y.push_back(static_cast<float>(v));
}

LightFieldPlane::Cell LightFieldPlane::cell(const std::array<float, 3>& way) const {
  const float along = dot(normal, way);
  const float steps = height / (std::abs(along) > kParallel ? along : kParallel);
  Cell cell;
  const int column = between(x, eye_x - steps * dot(right, way), cell.right);
  const int row = between(y, eye_y - steps * dot(down, way), cell.down);
  cell.first = row * static_cast<int>(x.size()) + column;
  return cell;
}

ShortList<int, kMostListed> strongest(const Scene::Impl& scene, const LightFieldPlane& plane,
                                      const View& view) {
  const Eigen::Vector3d ahead = view.view_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  const LightFieldPlane::Cell cell = plane.cell(floats(ahead));
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return LightFieldPlane::weight(a, cell.right, cell.down) >
           LightFieldPlane::weight(b, cell.right, cell.down);
  });
  ShortList<int, kMostListed> cameras;
  for (std::size_t k : order) {
    const int camera = plane.cameras[static_cast<std::size_t>(cell.first + plane.offset(k))];
    cameras.push_back(scene.rig_index[static_cast<std::size_t>(camera)]);
  }
  return cameras;
}

}  // namespace floatstage::render
