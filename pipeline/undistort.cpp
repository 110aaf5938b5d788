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

Retaking::Retaking(const CameraModel& from, const CameraModel& to)
    : width_(to.width),
      height_(to.height),
      sources_(static_cast<std::size_t>(to.width) * to.height, Eigen::Vector2d(-1, -1)) {
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::optional<Eigen::Vector3d> ray = unproject(to, {x + 0.5, y + 0.5});
      const std::optional<Eigen::Vector2d> p = ray ? project(from, *ray) : std::nullopt;
      if (p && inside(from, *p)) sources_[index(x, y)] = *p;
    }
}

Image Retaking::operator()(const Image& photograph) const {
  Image result(width_, height_, photograph.channels);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::optional<Eigen::Vector2d> p = source(x, y);
      if (!p) continue;
      for (int c = 0; c < photograph.channels; ++c)
        result.at(x, y)[c] = static_cast<std::uint8_t>(
            std::clamp(std::lround(read_bicubic(photograph, p->x(), p->y(), c)), 0L, 255L));
    }
  return result;
}

Image retaken(const Image& photograph, const CameraModel& from, const CameraModel& to) {
  return from == to ? photograph : Retaking(from, to)(photograph);
}

}  // namespace floatstage::pipeline
