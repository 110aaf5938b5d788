#include "pipeline/evaluate/undistort.h"

#include <algorithm>
#include <cmath>

#include "pipeline/evaluate/bicubic.h"

namespace floatstage::pipeline {
Image undistorted(const Image& photograph, const CameraModel& model) {
  if (std::holds_alternative<std::monostate>(model.lens)) return photograph;
  Image result(photograph.width, photograph.height, photograph.channels);
  const CameraModel ideal = pinhole(model);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const std::optional<Eigen::Vector3d> ray = unproject(ideal, {x + 0.5, y + 0.5});
      const std::optional<Eigen::Vector2d> p = ray ? project(model, *ray) : std::nullopt;
      if (!p || !inside(model, *p)) continue;
      for (int c = 0; c < photograph.channels; ++c)
        result.at(x, y)[c] = static_cast<std::uint8_t>(
            std::clamp(std::lround(read_bicubic(photograph, p->x(), p->y(), c)), 0L, 255L));
    }
  }
  return result;
}

}  // namespace floatstage::pipeline
