#include "pipeline/evaluate/undistort.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace floatstage::pipeline {
namespace {

std::array<double, 4> catmull_rom(double t) {
  return {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1, ((-1.5 * t + 2) * t + 0.5) * t,
          (0.5 * t - 0.5) * t * t};
}

// `p` in corner convention: the first pixel's centre is at 0.5.
void sample_bicubic(const Image& image, const Eigen::Vector2d& p, std::uint8_t* out) {
  const double x = p.x() - 0.5, y = p.y() - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const std::array<double, 4> wx = catmull_rom(x - x0), wy = catmull_rom(y - y0);
  for (int c = 0; c < image.channels; ++c) {
    double sum = 0;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        sum += wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)] *
               image.at(std::clamp(x0 + i - 1, 0, image.width - 1),
                        std::clamp(y0 + j - 1, 0, image.height - 1))[c];
    out[c] = static_cast<std::uint8_t>(std::clamp(std::lround(sum), 0L, 255L));
  }
}

}  // namespace

Image undistorted(const Image& photograph, const CameraModel& model) {
  if (std::holds_alternative<std::monostate>(model.lens)) return photograph;
  Image result(photograph.width, photograph.height, photograph.channels);
  const CameraModel ideal = pinhole(model);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const std::optional<Eigen::Vector3d> ray = unproject(ideal, {x + 0.5, y + 0.5});
      const std::optional<Eigen::Vector2d> p = ray ? project(model, *ray) : std::nullopt;
      if (p && inside(model, *p)) sample_bicubic(photograph, *p, result.at(x, y));
    }
  }
  return result;
}

}  // namespace floatstage::pipeline
