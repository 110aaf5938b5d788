#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"

namespace floatstage::detail {

/// Linear light of one pixel, red green blue, 0 to 1; the fourth is for whole vectors.
using Light = std::array<float, 4>;

/// A picture in linear light, rows top first.
struct LightPicture {
  int width = 0, height = 0;
  std::vector<Light> pixels;

  LightPicture() = default;
  LightPicture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * h, Light{}) {}
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  Light& at(int x, int y) { return pixels[index(x, y)]; }
  const Light& at(int x, int y) const { return pixels[index(x, y)]; }
};

/// One number a pixel.
struct Field {
  int width = 0, height = 0;
  std::vector<float> values;

  Field() = default;
  Field(int w, int h, float value = 0)
      : width(w), height(h), values(static_cast<std::size_t>(w) * h, value) {}
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
  float& at(int x, int y) { return values[index(x, y)]; }
  float at(int x, int y) const { return values[index(x, y)]; }
};

/// Lanczos' kernel of three lobes at a point whose corners are whole numbers, overshoots cut off; beyond the
/// border the border's pixel.
Light interpolated(const LightPicture& picture, double x, double y);

/// From and to 8 bits with the curve of sRGB (IEC 61966-2-1). `rgb`: 3 channels. The way back rounds and
/// clamps.
LightPicture to_light(const Image& rgb);
Image to_image(const LightPicture& picture);
/// The same with the fourth number as a channel of opacity.
Image to_image_with_opacity(const LightPicture& picture);
/// The curve itself, 0 to 1.
float encoded(float light);

/// A picture as one sees it through a homography: pixel (x, y) of the result shows `from_result` of its
/// centre. Where the result is coarser than the picture, its pixels average what they cover (by halving the
/// picture first); else Lanczos' kernel of three lobes, overshoots cut off. Beyond the border the border's
/// pixels.
LightPicture warped(const LightPicture& picture, const Eigen::Matrix3d& from_result, int width, int height,
                    int threads = 0);

}  // namespace floatstage::detail
