#include "core/synthetic/noise.h"

#include <algorithm>
#include <cmath>

namespace floatstage::synthetic {
namespace {

std::uint32_t mix32(std::uint32_t h) {
  h = (h ^ (h >> 16)) * 0x7FEB352Du;
  h = (h ^ (h >> 15)) * 0x846CA68Bu;
  return h ^ (h >> 16);
}

float fade(float t) { return t * t * (3 - 2 * t); }

}  // namespace

float lattice(int x, int y, int z, std::uint32_t seed) {
  const std::uint32_t h = mix32(static_cast<std::uint32_t>(x) * 0x8DA6B343u ^ static_cast<std::uint32_t>(y) * 0xD8163841u ^
                                static_cast<std::uint32_t>(z) * 0xCB1AB31Fu ^ seed * 0x9E3779B9u);
  return static_cast<float>(h >> 8) * 0x1.0p-24f;
}

float value_noise(const Eigen::Vector3f& p, std::uint32_t seed) {
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const float u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  auto along_x = [&](int dy, int dz) {
    const float a = lattice(x, y + dy, z + dz, seed);
    return a + u * (lattice(x + 1, y + dy, z + dz, seed) - a);
  };
  auto along_y = [&](int dz) {
    const float a = along_x(0, dz);
    return a + v * (along_x(1, dz) - a);
  };
  const float a = along_y(0);
  return a + w * (along_y(1) - a);
}

float soft_step(float edge, float x, float width) { return std::clamp((x - edge) / width + 0.5f, 0.0f, 1.0f); }

float stripes(float x, float period, float duty, float width) {
  const float w = std::max(width / period, 1e-4f), center = x / period;
  auto integral = [duty](float t) {
    const float whole = std::floor(t);
    return whole * duty + std::min(t - whole, duty);
  };
  return (integral(center + w / 2) - integral(center - w / 2)) / w;
}

}  // namespace floatstage::synthetic
