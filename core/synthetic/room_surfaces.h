#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "core/synthetic/stage.h"

namespace floatstage::synthetic {

/// A point on the inside of the room's box.
struct RoomPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< metres, world
  int axis = 2;                                        ///< of the side's normal: 2 is floor or ceiling
  bool floor = true;                                   ///< of axis 2, the lower side
  float along = 0;                                     ///< metres along a wall, sideways
  float light = 1;                                     ///< of the lamps there, about 1
};

/// Colour 0…1 (gamma space) of a side. Deterministic.
Eigen::Vector3f room_surface(SyntheticStage stage, const RoomPoint& point, std::uint32_t seed);

/// The colour of a stage's green cloth in full light.
inline const Eigen::Vector3f kGreenCloth(0.165f, 0.655f, 0.270f);

}  // namespace floatstage::synthetic
