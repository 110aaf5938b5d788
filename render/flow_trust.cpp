#include "render/flow_trust.h"

#include <algorithm>
#include <cmath>

namespace floatstage::render {
namespace {

constexpr float kLargestRoundTrip = 0.7F;  // px by which the way there and back may miss
constexpr float kLargestResidual =
    10;                           // 8-bit steps, mean over a neighbourhood: beyond it nothing was matched
constexpr int kNeighborhood = 2;  // px to each side

/// A plane of one number a pixel.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// Mean over a square neighbourhood, cut at the border (where fewer pixels count as the full number: a little
/// trusting).
void box_mean(Plane& plane, int radius) {
  const float share = 1.F / static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  std::vector<float> rows(plane.values.size());
  for (int y = 0; y < plane.height; ++y) {
    float sum = 0;
    for (int x = -radius; x < plane.width; ++x) {
      if (x + radius < plane.width) sum += plane.values[plane.at(x + radius, y)];
      if (x - radius - 1 >= 0) sum -= plane.values[plane.at(x - radius - 1, y)];
      if (x >= 0) rows[plane.at(x, y)] = sum;
    }
  }
  for (int x = 0; x < plane.width; ++x) {
    float sum = 0;
    for (int y = -radius; y < plane.height; ++y) {
      if (y + radius < plane.height) sum += rows[plane.at(x, y + radius)];
      if (y - radius - 1 >= 0) sum -= rows[plane.at(x, y - radius - 1)];
      if (y >= 0) plane.values[plane.at(x, y)] = sum * share;
    }
  }
}

float bilinear(const std::vector<std::uint8_t>& gray, const Plane& size, float x, float y) {
  x = std::clamp(x, 0.F, static_cast<float>(size.width - 1));
  y = std::clamp(y, 0.F, static_cast<float>(size.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, size.width - 1), y1 = std::min(y0 + 1, size.height - 1);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  auto value = [&](int u, int v) { return static_cast<float>(gray[size.at(u, v)]); };
  return (value(x0, y0) * (1 - fx) + value(x1, y0) * fx) * (1 - fy) +
         (value(x0, y1) * (1 - fx) + value(x1, y1) * fx) * fy;
}

/// How far image `to`, fetched along `flow` (null: none), is from image `from`, smoothed.
Plane residual(const ProjectedImages& images, std::size_t from, std::size_t to, const FlowField* flow) {
  Plane out{images.width, images.height, std::vector<float>(images.gray[from].size())};
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const std::size_t i = out.at(x, y);
      const float u = flow != nullptr ? flow->uv[2 * i] : 0, v = flow != nullptr ? flow->uv[2 * i + 1] : 0;
      const float there =
          bilinear(images.gray[to], out, static_cast<float>(x) + u, static_cast<float>(y) + v);
      out.values[i] = std::abs(static_cast<float>(images.gray[from][i]) - there);
    }
  }
  box_mean(out, kNeighborhood);
  return out;
}

}  // namespace

std::vector<bool> trusted(const ProjectedImages& images, std::size_t from, std::size_t to,
                          const FlowField& there, const FlowField* back) {
  const std::vector<std::uint8_t>&start = images.state[from], &end = images.state[to];
  const Plane before = residual(images, from, to, nullptr), after = residual(images, from, to, &there);
  std::vector<bool> good(start.size());
  for (int y = 0; y < images.height; ++y) {
    for (int x = 0; x < images.width; ++x) {
      const std::size_t i = after.at(x, y);
      if (start[i] != ProjectedImages::kOwn || end[i] != ProjectedImages::kOwn) continue;
      if (after.values[i] > std::min(kLargestResidual, before.values[i])) continue;
      const float u = there.uv[2 * i], v = there.uv[2 * i + 1];
      const long tx = std::lround(static_cast<float>(x) + u), ty = std::lround(static_cast<float>(y) + v);
      if (tx < 0 || ty < 0 || tx >= images.width || ty >= images.height) continue;
      const std::size_t t = after.at(static_cast<int>(tx), static_cast<int>(ty));
      if (end[t] != ProjectedImages::kOwn) continue;
      good[i] =
          back == nullptr || std::hypot(u + back->uv[2 * t], v + back->uv[2 * t + 1]) <= kLargestRoundTrip;
    }
  }
  return good;
}

}  // namespace floatstage::render
