#include "core/color.h"

#include <algorithm>
#include <cmath>

namespace floatstage {

Eigen::Vector3d apply(const ColorTransform& t, const Eigen::Vector3d& rgb) {
  Eigen::Vector3d light;
  for (int i = 0; i < 3; ++i) light[i] = std::pow(std::clamp(rgb[i], 0.0, 1.0), t.decode[i]);
  light = t.matrix * light;
  for (int i = 0; i < 3; ++i) light[i] = std::pow(std::clamp(light[i], 0.0, 1.0), 1 / t.encode);
  return light;
}

ColorTable::ColorTable(const ColorTransform& t) : matrix_(t.matrix) {
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t v = 0; v < 256; ++v)
      light_[c][v] = std::pow(static_cast<double>(v) / 255, t.decode[static_cast<Eigen::Index>(c)]);
  if (t.encode == 1) return;
  byte_.resize(kLight + 1);
  for (int i = 0; i <= kLight; ++i)
    byte_[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255 * std::pow(static_cast<double>(i) / kLight, 1 / t.encode)));
}

void ColorTable::apply(const std::uint8_t* from, std::uint8_t* to) const {
  const Eigen::Vector3d light =
      matrix_ * Eigen::Vector3d(light_[0][from[0]], light_[1][from[1]], light_[2][from[2]]);
  for (int i = 0; i < 3; ++i) {
    const double v = std::clamp(light[i], 0.0, 1.0);
    to[i] = byte_.empty() ? static_cast<std::uint8_t>(std::lround(255 * v))
                          : byte_[static_cast<std::size_t>(std::lround(kLight * v))];
  }
}

}  // namespace floatstage
