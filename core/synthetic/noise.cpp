#include "core/synthetic/noise.h"

#include <algorithm>
#include <cmath>

namespace floatstage::synthetic {
namespace {

constexpr std::uint32_t kX = 0x8DA6B343u, kY = 0xD8163841u, kZ = 0xCB1AB31Fu, kSeed = 0x9E3779B9u;

// A finisher of two multiplications: textures ask for millions of these numbers a picture.
float finish(std::uint32_t h) {
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  return static_cast<float>(h >> 8) * 0x1.0p-24f;
}

std::uint32_t bits(int v) { return static_cast<std::uint32_t>(v); }

float fade(float t) { return t * t * (3 - 2 * t); }

}  // namespace

float lattice(int x, int y, int z, std::uint32_t seed) {
  return finish(bits(x) * kX ^ bits(y) * kY ^ bits(z) * kZ ^ seed * kSeed);
}

float value_noise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const float u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  const std::uint32_t hx[2] = {bits(x) * kX, bits(x + 1) * kX}, hy[2] = {bits(y) * kY, bits(y + 1) * kY};
  const std::uint32_t hz[2] = {bits(z) * kZ ^ seed * kSeed, bits(z + 1) * kZ ^ seed * kSeed};
  auto along_x = [&](int dy, int dz) {
    const std::uint32_t h = hy[dy] ^ hz[dz];
    const float a = finish(hx[0] ^ h);
    return a + u * (finish(hx[1] ^ h) - a);
  };
  auto along_y = [&](int dz) {
    const float a = along_x(0, dz);
    return a + v * (along_x(1, dz) - a);
  };
  const float a = along_y(0);
  return a + w * (along_y(1) - a);
}

float soft_step(float edge, float x, float width) {
  return std::clamp((x - edge) / width + 0.5f, 0.0f, 1.0f);
}

float stripes(float x, float period, float duty, float width) {
  const float w = std::max(width / period, 1e-4f), center = x / period;
  auto integral = [duty](float t) {
    const float whole = std::floor(t);
    return whole * duty + std::min(t - whole, duty);
  };
  return (integral(center + w / 2) - integral(center - w / 2)) / w;
}

}  // namespace floatstage::synthetic
