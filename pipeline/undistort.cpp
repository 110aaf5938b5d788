#include "pipeline/undistort.h"

#include <algorithm>
#include <cmath>

#include "pipeline/bicubic.h"

namespace floatstage::pipeline {

Image undistorted(const Image& photograph, const CameraModel& model) {
  return retaken(photograph, model, pinhole(model));
}

CameraModel straight(CameraModel model) {
  model = pinhole(model);
  model.skew = 0;
  return model;
}

Image retaken(const Image& photograph, const CameraModel& from, const CameraModel& to) {
  if (from == to) return photograph;
  Image result(to.width, to.height, photograph.channels);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const std::optional<Eigen::Vector3d> ray = unproject(to, {x + 0.5, y + 0.5});
      const std::optional<Eigen::Vector2d> p = ray ? project(from, *ray) : std::nullopt;
      if (!p || !inside(from, *p)) continue;
      for (int c = 0; c < photograph.channels; ++c)
        result.at(x, y)[c] = static_cast<std::uint8_t>(
            std::clamp(std::lround(read_bicubic(photograph, p->x(), p->y(), c)), 0L, 255L));
    }
  }
  return result;
}

}  // namespace floatstage::pipeline
