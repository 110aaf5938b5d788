#pragma once

#include "core/rig.h"
#include "core/text.h"

namespace floatstage {

/// `rows` by `columns` cameras side by side, `pitch` metres apart, that look along +y from around (0,
/// -distance, 0); row after row from the top left.
inline Rig camera_wall(int rows, int columns, double pitch = 0.1, double distance = 1, int width = 160,
                       int height = 120) {
  Rig rig;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      RigCamera c;
      c.serial = text("r", row, "c", column);
      c.model = {.width = width,
                 .height = height,
                 .fx = 1.5 * width,
                 .fy = 1.5 * width,
                 .cx = 0.5 * width,
                 .cy = 0.5 * height,
                 .skew = 0,
                 .lens = {}};
      const double x = pitch * (column - 0.5 * (columns - 1)), z = -pitch * (row - 0.5 * (rows - 1));
      c.cam_from_world = look_at({x, -distance, z}, {x, 0, z}, {0, 0, 1});
      rig.cameras.push_back(c);
    }
  return rig;
}

}  // namespace floatstage
