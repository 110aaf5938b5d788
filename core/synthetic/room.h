#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "core/rig.h"
#include "core/synthetic/stage.h"

namespace floatstage::synthetic {

/// The studio's walls, floor and ceiling: a box that holds every camera, unevenly lit, of cloth with slight
/// folds or of what else the stage shows. It catches no shadow: the plate is what the picture shows wherever
/// the performer is not.
class Room {
 public:
  Room(const Rig& rig, SyntheticStage stage, std::uint64_t seed);

  /// Colour 0…1 (gamma space) seen along a ray. A ray that misses the room sees black.
  Eigen::Vector3f color(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;

 private:
  Eigen::Vector3f low_, high_;
  SyntheticStage stage_;
  std::uint32_t seed_;
};

}  // namespace floatstage::synthetic
