#include "render/cpu/false_color.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace floatstage::render::cpu {
namespace {

constexpr float kLongestWarp = 8;  // px: the flow's full colour

std::array<float, 3> hue(float h) {
  std::array<float, 3> rgb{};
  const float shift[3] = {0, 2.F / 3, 1.F / 3};
  for (std::size_t c = 0; c < 3; ++c) {
    const float turn = h + shift[c], part = turn - std::floor(turn);
    rgb[c] = std::clamp(std::abs(part * 6 - 3) - 1, 0.F, 1.F);
  }
  return rgb;
}

}  // namespace

std::array<float, 3> camera_color(int index) {
  const float turn = 0.11F + 0.618034F * static_cast<float>(index);
  std::array<float, 3> rgb = hue(turn - std::floor(turn));
  for (float& c : rgb) c = 255 * (0.25F + 0.75F * c);
  return rgb;
}

std::array<float, 3> flow_color(float u, float v) {
  const float direction = std::atan2(v, u) / (2 * std::numbers::pi_v<float>),
              amount = std::min(std::hypot(u, v) / kLongestWarp, 1.F);
  std::array<float, 3> rgb = hue(direction);
  for (float& c : rgb) c = 255 * (1 + amount * (c - 1));
  return rgb;
}

std::array<float, 3> heat_color(float amount) {
  std::array<float, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = 255 * std::clamp(3 * amount - static_cast<float>(c), 0.F, 1.F);
  return rgb;
}

std::array<float, 3> spacing_color(float spacing) {
  const float octaves = std::clamp(std::log2(std::max(spacing, 1e-6F)) / 2, -1.F, 1.F);
  const float rest = 255 * (1 - std::abs(octaves));
  return {octaves < 0 ? rest : 255, rest, octaves > 0 ? rest : 255};
}

std::array<float, 3> class_color(BlendClass of_blend) {
  switch (of_blend) {
    case BlendClass::Sharp:
      return {64, 176, 80};
    case BlendClass::Blurred:
      return {64, 96, 224};
    case BlendClass::Ghost:
      return {224, 48, 48};
  }
  return {};
}

}  // namespace floatstage::render::cpu
