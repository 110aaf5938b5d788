#include "detail/float_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace floatstage::detail {
namespace {

float decoded(float v) { return v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F); }

LightPicture halved(const LightPicture& p) {
  LightPicture out((p.width + 1) / 2, (p.height + 1) / 2);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int u = std::min(2 * x + 1, p.width - 1), v = std::min(2 * y + 1, p.height - 1);
      const Light &a = p.at(2 * x, 2 * y), &b = p.at(u, 2 * y), &c = p.at(2 * x, v), &d = p.at(u, v);
      for (std::size_t k = 0; k < 4; ++k) out.at(x, y)[k] = (a[k] + b[k] + c[k] + d[k]) / 4;
    }
  return out;
}

constexpr int kTaps = 6, kPhases = 512;

// Lanczos' kernel of three lobes at kPhases places between the third and the fourth of six neighbours.
const std::vector<std::array<float, kTaps>>& lanczos() {
  static const std::vector<std::array<float, kTaps>> table = [] {
    std::vector<std::array<float, kTaps>> rows(kPhases + 1);
    const auto sinc = [](double t) {
      return t == 0 ? 1 : std::sin(std::numbers::pi * t) / (std::numbers::pi * t);
    };
    for (int p = 0; p <= kPhases; ++p) {
      std::array<double, kTaps> w{};
      double sum = 0;
      for (int i = 0; i < kTaps; ++i) {
        const double t = static_cast<double>(p) / kPhases - (i - 2);
        w[static_cast<std::size_t>(i)] = std::abs(t) >= 3 ? 0 : sinc(t) * sinc(t / 3);
        sum += w[static_cast<std::size_t>(i)];
      }
      for (std::size_t i = 0; i < kTaps; ++i)
        rows[static_cast<std::size_t>(p)][i] = static_cast<float>(w[i] / sum);
    }
    return rows;
  }();
  return table;
}

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
}

void encode(const Light& light, std::uint8_t* rgb) {
  for (std::size_t k = 0; k < 3; ++k) rgb[k] = rounded(encoded(std::clamp(light[k], 0.0F, 1.0F)));
}

}  // namespace

Light interpolated(const LightPicture& p, double x, double y) {
  x = std::clamp(x - 0.5, -3.0, p.width + 2.0);
  y = std::clamp(y - 0.5, -3.0, p.height + 2.0);
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const auto& wx = lanczos()[static_cast<std::size_t>(std::lround((x - i) * kPhases))];
  const auto& wy = lanczos()[static_cast<std::size_t>(std::lround((y - j) * kPhases))];
  Light out{};
  for (int b = 0; b < kTaps; ++b) {
    const Light* row = &p.pixels[p.index(0, std::clamp(j + b - 2, 0, p.height - 1))];
    Light sum{};
    for (int a = 0; a < kTaps; ++a) {
      const Light& from = row[std::clamp(i + a - 2, 0, p.width - 1)];
      for (std::size_t k = 0; k < 4; ++k) sum[k] += wx[static_cast<std::size_t>(a)] * from[k];
    }
    for (std::size_t k = 0; k < 4; ++k) out[k] += wy[static_cast<std::size_t>(b)] * sum[k];
  }
  for (float& v : out) v = std::clamp(v, 0.0F, 1.0F);  // an overshoot is no light
  return out;
}

float encoded(float light) {
  return light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
}

LightPicture to_light(const Image& rgb) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < 256; ++i) table[i] = decoded(static_cast<float>(i) / 255.0F);
  LightPicture out(rgb.width, rgb.height);
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) out.pixels[i][k] = table[rgb.pixels[3 * i + k]];
  return out;
}

Image to_image(const LightPicture& picture) {
  Image out(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) encode(picture.pixels[i], &out.pixels[3 * i]);
  return out;
}

Image to_image_with_opacity(const LightPicture& picture) {
  Image out(picture.width, picture.height, 4);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    encode(picture.pixels[i], &out.pixels[4 * i]);
    out.pixels[4 * i + 3] = rounded(picture.pixels[i][3]);
  }
  return out;
}

LightPicture warped(const LightPicture& picture, const Eigen::Matrix3d& from_result, int width, int height,
                    int threads) {
  // How many pixels of the picture one of the result covers, at its middle.
  const auto at = [&](double x, double y) {
    return Eigen::Vector2d((from_result * Eigen::Vector3d(x, y, 1)).hnormalized());
  };
  const Eigen::Vector2d middle = at(width / 2.0, height / 2.0);
  const double step = std::sqrt((at(width / 2.0 + 1, height / 2.0) - middle).norm() *
                                (at(width / 2.0, height / 2.0 + 1) - middle).norm());
  LightPicture small;
  double scale = 1;
  while (step * scale > 1.5 && picture.width * scale > 8 && picture.height * scale > 8) {
    small = halved(scale == 1 ? picture : small);
    scale /= 2;
  }
  const LightPicture& from = scale == 1 ? picture : small;
  LightPicture out(width, height);
  parallel_for(static_cast<std::size_t>(height), threads, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d p = at(x + 0.5, y + 0.5);
      out.at(x, y) = interpolated(from, p.x() * scale, p.y() * scale);
    }
  });
  return out;
}

}  // namespace floatstage::detail
