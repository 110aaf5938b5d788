#pragma once

#include <cmath>
#include <cstdint>

#include "core/camera.h"
#include "core/image.h"
#include "core/matte.h"
#include "core/rig.h"

namespace floatstage {

/// Draws two hard shadows onto the floor (z = 0) of an RGB picture, about the middle of the stage, bluer than
/// what they fall on, wherever the camera does not see the subject.
inline void cast_shadows(const RigCamera& camera, const Matte& subject, Image& picture) {
  constexpr double kLeft[] = {0.42, 0.52, 0.63}, kReach = 1.5;
  const Eigen::Vector3d eye = camera.cam_from_world.center();
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const Eigen::Vector3d along =
          camera.cam_from_world.rotation.conjugate() * *unproject(camera.model, {x + 0.5, y + 0.5});
      const Eigen::Vector3d at = eye - eye.z() / along.z() * along;
      const bool shaded = std::abs(at.y() - 0.4 * at.x()) < 0.15 || std::abs(at.x() + at.y()) < 0.12;
      if (along.z() >= 0 || at.norm() > kReach || !shaded || subject.row(y)[x] > 0) continue;
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(kLeft[c] * picture.at(x, y)[c]);
    }
}

}  // namespace floatstage
