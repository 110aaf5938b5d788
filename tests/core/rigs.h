#pragma once

#include <cmath>
#include <string>

#include "core/rig.h"

namespace floatstage {

/// `count` cameras of 640x480 on a circle of 3 m around (0, 0, 1), all looking at it.
inline Rig ring(int count) {
  Rig rig;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159265358979 * i / count;
    RigCamera c;
    c.serial = "cam" + std::to_string(i);
    c.model = {
        .width = 640, .height = 480, .fx = 500, .fy = 501, .cx = 320, .cy = 240, .skew = 0, .lens = {}};
    c.cam_from_world = look_at({3 * std::cos(angle), 3 * std::sin(angle), 1}, {0, 0, 1}, {0, 0, 1});
    rig.cameras.push_back(c);
  }
  return rig;
}

}  // namespace floatstage
