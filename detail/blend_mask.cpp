// The gradient-density mask: M. Eisemann, section 4.3.4, Eq. 4.5 to 4.7. Ways are found by sweeps in four
// directions until no cost falls (dynamic programming; R. Bellman). Differs: a step costs at least a quarter
// of the mean gradient, else flat regions would never become opaque (ADR 0217).

#include "detail/blend_mask.h"

#include <algorithm>
#include <cmath>

namespace floatstage::detail {
namespace {

constexpr float kShare = 0.4F, kLeastStep = 0.25F, kFar = 1e9F;
constexpr int kMostRounds = 12;

// |dx| + |dy| of the encoded channel.
Field gradients(const LightPicture& p, std::size_t channel) {
  Field values(p.width, p.height), out(p.width, p.height);
  for (std::size_t i = 0; i < values.values.size(); ++i) values.values[i] = encoded(p.pixels[i][channel]);
  double sum = 0;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const float dx = values.at(std::min(x + 1, p.width - 1), y) - values.at(std::max(x - 1, 0), y);
      const float dy = values.at(x, std::min(y + 1, p.height - 1)) - values.at(x, std::max(y - 1, 0));
      out.at(x, y) = (std::abs(dx) + std::abs(dy)) / 2;
      sum += static_cast<double>(out.at(x, y));
    }
  const auto least = static_cast<float>(kLeastStep * sum / static_cast<double>(out.values.size())) + 1e-6F;
  for (float& v : out.values) v = std::max(v, least);
  return out;
}

// Lowers costs along rows of one direction; whether any fell.
bool sweep(const Field& step, Field& cost, bool down) {
  bool fell = false;
  const int w = cost.width, h = cost.height;
  const auto lower = [&](float& c, float from, float with) {
    if (from + with < c) c = from + with, fell = true;
  };
  for (int j = 0; j < h; ++j) {
    const int y = down ? j : h - 1 - j, before = down ? y - 1 : y + 1;
    float* row = &cost.at(0, y);
    const float* steps = &step.values[step.index(0, y)];
    if (j > 0) {
      const float* other = &cost.values[cost.index(0, before)];
      for (int x = 0; x < w; ++x) lower(row[x], other[x], steps[x]);
    }
    for (int x = 1; x < w; ++x) lower(row[x], row[x - 1], steps[x]);
    for (int x = w - 2; x >= 0; --x) lower(row[x], row[x + 1], steps[x]);
  }
  return fell;
}

}  // namespace

Field blending_mask(const LightPicture& picture, const std::vector<std::uint8_t>& child) {
  Field most(picture.width, picture.height);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const Field step = gradients(picture, channel);
    Field cost(picture.width, picture.height);
    for (std::size_t i = 0; i < child.size(); ++i) cost.values[i] = child[i] != 0 ? kFar : 0;
    for (int x = 0; x < picture.width; ++x)  // beyond the edge is the parent
      for (const int y : {0, picture.height - 1}) cost.at(x, y) = 0;
    for (int y = 0; y < picture.height; ++y)
      for (const int x : {0, picture.width - 1}) cost.at(x, y) = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const bool down = sweep(step, cost, true), up = sweep(step, cost, false);
      if (!down && !up) break;
    }
    for (std::size_t i = 0; i < most.values.size(); ++i)
      most.values[i] = std::max(most.values[i], cost.values[i]);
  }
  const float full = kShare * *std::max_element(most.values.begin(), most.values.end());
  for (float& v : most.values) v = full > 0 ? std::min(1.0F, v / full) : 0;
  return most;
}

}  // namespace floatstage::detail
