#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "calib/silhouettes/silhouette_turn.h"
#include "core/random.h"
#include "core/rig.h"
#include "pipeline/silhouettes/silhouette_check.h"
#include "recon/visual_hull.h"

namespace floatstage::test {

struct TurnedCamera {
  Rig rig;
  std::string serial;
};

/// One camera turned about its centre, around an axis that the seed chooses.
inline TurnedCamera turn_one(const Rig& rig, double degrees, std::uint64_t seed) {
  Random random(seed + 1);
  TurnedCamera out{rig, {}};
  RigCamera& camera = out.rig.cameras[seed % rig.cameras.size()];
  const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  camera.cam_from_world =
      calib::turned(camera.cam_from_world, degrees * std::numbers::pi / 180 * axis.normalized());
  out.serial = camera.serial;
  return out;
}

inline double degrees_apart(const Rig& a, const Rig& b, const std::string& serial) {
  const auto pose = [&](const Rig& rig) {
    return rig.cameras[static_cast<std::size_t>(camera_index(rig, serial))].cam_from_world.rotation;
  };
  return pose(a).angularDistance(pose(b)) * 180 / std::numbers::pi;
}

inline std::vector<std::string> named_by(const pipeline::SilhouetteCheck& check) {
  std::vector<std::string> out;
  for (const pipeline::SilhouetteCameraCheck& c : check.cameras)
    if (c.named) out.push_back(c.serial);
  return out;
}

/// Of the strict hulls' silhouettes with the mattes, over all instants.
inline double mean_hull_iou(const Rig& rig, const std::vector<pipeline::InstantMattes>& instants) {
  double sum = 0;
  int count = 0;
  for (const pipeline::InstantMattes& mattes : instants) {
    const auto hull = recon::visual_hull(rig, mattes, recon::HullOptions());
    if (!hull) continue;
    for (const double iou : hull->silhouette_iou)
      if (!std::isnan(iou)) sum += iou, ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace floatstage::test
