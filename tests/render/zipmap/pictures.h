#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/random.h"
#include "render/zipmap/zipmap.h"

/// Pictures and places for zipmaps.
namespace floatstage::render::test {

inline Image noise(int width, int height, int channels, std::uint64_t seed) {
  Random random(seed);
  Image image(width, height, channels);
  for (std::uint8_t& v : image.pixels) v = static_cast<std::uint8_t>(random.next() & 255);
  return image;
}

/// Over the part of the root that begins at (u, v) and is `size` wide and high.
inline Zipmap::Patch patch(std::size_t picture, double u, double v, double size) {
  Zipmap::Patch p{picture, Eigen::Matrix3d::Identity()};
  p.patch_from_root(0, 0) = p.patch_from_root(1, 1) = 1 / size;
  p.patch_from_root(0, 2) = -u / size;
  p.patch_from_root(1, 2) = -v / size;
  return p;
}

/// A window of the root, `size` wide, on so many pixels.
inline Eigen::Matrix3d window(double u, double v, double size, int width) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m(0, 0) = m(1, 1) = size / width;
  m(0, 2) = u;
  m(1, 2) = v;
  return m;
}

inline double mean_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(a.pixels[i] - b.pixels[i]);
  return sum / static_cast<double>(a.pixels.size());
}

/// Patches that show the same thing ever closer, as photographs do. It is gentle enough that what moves by a
/// pixel's part changes little: what is left are jumps.
inline Zipmap ever_closer() {
  const auto scene = [](double u, double v) {
    return 128 + 50 * std::sin(6 * u + 3 * v) + 12 * std::sin(90 * u * v) + 4 * std::cos(220 * v + 11 * u);
  };
  const auto photograph = [&](double u, double v, double size, int n) {
    Image image(n, n, 3);
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y)[c] = static_cast<std::uint8_t>(
              std::clamp(scene(u + size * (x + 0.5) / n, v + size * (y + 0.5) / n), 0.0, 255.0));
    return image;
  };
  return *Zipmap::make(
      photograph(0, 0, 1, 256),
      {photograph(0.3, 0.3, 0.4, 201), photograph(0.42, 0.42, 0.16, 239), photograph(0.47, 0.47, 0.06, 256)},
      {patch(0, 0.3, 0.3, 0.4), patch(1, 0.42, 0.42, 0.16), patch(2, 0.47, 0.47, 0.06)});
}

/// Many patches of three small pictures, all over the root.
inline Zipmap scattered(int count, std::uint64_t seed = 7) {
  Random random(seed);
  std::vector<Zipmap::Patch> patches;
  for (int i = 0; i < count; ++i)
    patches.push_back(
        patch(static_cast<std::size_t>(i % 3), random.uniform(0, 0.7), random.uniform(0, 0.7), 0.3));
  return *Zipmap::make(noise(40, 30, 3, 1), {noise(20, 20, 4, 2), noise(31, 17, 4, 3), noise(64, 64, 4, 4)},
                       patches);
}

/// 32x into 2048²: a root and four photographs of its size, each twice as close as the last, the last four
/// times.
inline Zipmap thirty_two_times() {
  std::vector<Image> pictures;
  std::vector<Zipmap::Patch> patches;
  double size = 1;
  for (std::size_t i = 0; i < 4; ++i) {
    pictures.emplace_back(2048, 2048, 3, 90);
    size /= i == 3 ? 4 : 2;
    patches.push_back(patch(i, 0.5 - size / 2, 0.5 - size / 2, size));
  }
  return *Zipmap::make(Image(2048, 2048, 3, 80), pictures, patches);
}

}  // namespace floatstage::render::test
