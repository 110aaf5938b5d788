#include "pipeline/silhouettes/camera_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/ring.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kMissed = 5;     // of so many cameras one
constexpr std::size_t kWitnesses = 8;  // bound a body well enough to tell that a camera has turned

std::vector<std::size_t> order_around(const Rig& rig) {
  const Eigen::Vector3d axis = up_axis(rig).direction, center = fit_ring(rig, axis).center;
  const Eigen::Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<double> angles;
  for (const RigCamera& c : rig.cameras) {
    const Eigen::Vector3d from = c.cam_from_world.center() - center;
    angles.push_back(std::atan2(from.dot(y), from.dot(x)));
  }
  std::vector<std::size_t> order(angles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return angles[a] < angles[b]; });
  return order;
}

}  // namespace

CameraGroups::CameraGroups(const Rig& rig, bool large) : group_(rig.cameras.size()) {
  const std::size_t cameras = rig.cameras.size(), most = cameras > kWitnesses ? cameras - kWitnesses : 1,
                    together = large ? std::min(most, (cameras + 1) / 2)
                                     : std::max<std::size_t>(1, cameras / kMissed);
  count_ = (cameras + together - 1) / together;
  const std::vector<std::size_t> around = order_around(rig);
  for (std::size_t i = 0; i < cameras; ++i) group_[around[i]] = i % count_;
}

}  // namespace floatstage::pipeline
