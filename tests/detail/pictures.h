#pragma once

#include <cmath>

#include <Eigen/Core>

#include "core/image.h"
#include "core/random.h"

namespace floatstage::detail::test {

/// A world of smooth blobs at every size between `finest` and 64 units, grey-blue; the same everywhere and
/// always. Channels 0 to 1.
inline Eigen::Vector3d world(double x, double y, std::uint64_t seed, double finest = 2) {
  Eigen::Vector3d sum = Eigen::Vector3d::Constant(0.5);
  double weight = 0.16;
  for (double size = 64; size >= finest; size /= 2, weight *= 0.85) {
    const double u = x / size, v = y / size;
    const double i = std::floor(u), j = std::floor(v), a = u - i, b = v - j;
    const double fa = a * a * (3 - 2 * a), fb = b * b * (3 - 2 * b);
    for (int dj = 0; dj < 2; ++dj)
      for (int di = 0; di < 2; ++di) {
        const std::uint64_t h =
            mix(seed ^ mix(static_cast<std::uint64_t>(static_cast<std::int64_t>(i) + di) * 73856093 +
                           static_cast<std::uint64_t>(static_cast<std::int64_t>(j) + dj) * 19349663 +
                           static_cast<std::uint64_t>(size)));
        const double w = (di ? fa : 1 - fa) * (dj ? fb : 1 - fb) * weight;
        sum += w * Eigen::Vector3d((h & 1023) / 511.5 - 1, (h >> 10 & 1023) / 511.5 - 1,
                                   (h >> 20 & 1023) / 511.5 - 1);
      }
  }
  return sum.cwiseMax(0).cwiseMin(1);
}

/// A photograph of that world: pixel (x, y) shows world_from_pixel of its centre. Details finer than a pixel
/// are left out, as a lens would.
inline Image photograph(int width, int height, const Eigen::Matrix3d& world_from_pixel,
                        std::uint64_t seed = 1) {
  Image image(width, height, 3);
  const double pixel = std::sqrt(std::abs(world_from_pixel.topLeftCorner<2, 2>().determinant()));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d p = (world_from_pixel * Eigen::Vector3d(x + 0.5, y + 0.5, 1)).hnormalized();
      const Eigen::Vector3d c = world(p.x(), p.y(), seed, 2 * pixel);
      for (int k = 0; k < 3; ++k) image.at(x, y)[k] = static_cast<std::uint8_t>(std::lround(255 * c[k]));
    }
  return image;
}

/// World from pixel: pixels of `pixel` world units, turned by `radians`, the top left one at (x, y).
inline Eigen::Matrix3d view_of_world(double x, double y, double pixel, double radians = 0) {
  Eigen::Matrix3d m;
  m << pixel * std::cos(radians), -pixel * std::sin(radians), x, pixel * std::sin(radians),
      pixel * std::cos(radians), y, 0, 0, 1;
  return m;
}

}  // namespace floatstage::detail::test
