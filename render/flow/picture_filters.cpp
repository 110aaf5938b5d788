#include "render/flow/picture_filters.h"

#include <algorithm>

namespace floatstage::render {
namespace {

/// (1 2 1) at every pixel, or (1 3 3 1) at every second one.
struct Smooth {
  static constexpr int kTaps = 3, kStep = 1;
  static constexpr float kWeights[kTaps] = {1, 2, 1};
};
struct Halve {
  static constexpr int kTaps = 4, kStep = 2;
  static constexpr float kWeights[kTaps] = {1, 3, 3, 1};
};

/// The weighted sums of the rows under the filter at row `y`, of brightness and of what is known, with two
/// zeros at both ends.
template <class Filter>
void sum_rows(const PictureLevel& from, int y, float* sum, float* known) {
  for (int k = 0; k < Filter::kTaps; ++k) {
    const int row = Filter::kStep * y - 1 + k;
    if (row < 0 || row >= from.height) continue;
    const float weight = Filter::kWeights[k];
    const float* value = from.value.data() + from.at(0, row);
    const std::uint8_t* zone = from.zone.data() + from.at(0, row);
    if (from.whole) {
      for (int x = 0; x < from.width; ++x) sum[x] += weight * value[x];
      for (int x = 0; x < from.width; ++x) known[x] += weight;
      continue;
    }
    for (int x = 0; x < from.width; ++x) {
      const float w = zone[x] == PictureLevel::kDomain ? weight : 0.F;
      sum[x] += w * value[x];
      known[x] += w;
    }
  }
}

template <class Filter>
void filter(const PictureLevel& from, PictureLevel& to, std::vector<float>& scratch) {
  const auto padded = static_cast<std::size_t>(from.width + 4);
  for (int y = 0; y < to.height; ++y) {
    scratch.assign(2 * padded, 0.F);
    float *sum = scratch.data() + 1, *known = sum + padded, *out = to.value.data() + to.at(0, y);
    sum_rows<Filter>(from, y, sum, known);
    for (int x = 0; x < to.width; ++x) {
      const int left = Filter::kStep * x - 1;
      float total = 0, weight = 0;
      for (int k = 0; k < Filter::kTaps; ++k) {
        total += Filter::kWeights[k] * sum[left + k];
        weight += Filter::kWeights[k] * known[left + k];
      }
      out[x] = total / std::max(weight, 1.F);
    }
  }
}

void halve_zones(const PictureLevel& fine, PictureLevel& coarse) {
  if (fine.whole) {
    std::fill(coarse.zone.begin(), coarse.zone.end(), std::uint8_t{PictureLevel::kDomain});
    std::fill(coarse.own.begin(), coarse.own.end(), std::uint8_t{255});
    return;
  }
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      int count = 0, own = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, fine.height); ++v)
        for (int u = 2 * x; u < std::min(2 * x + 2, fine.width); ++u) {
          const std::size_t i = fine.at(u, v);
          if (fine.zone[i] != PictureLevel::kDomain) continue;
          ++count;
          own += fine.own[i];
        }
      const std::size_t to = coarse.at(x, y);
      coarse.zone[to] = count > 0 ? PictureLevel::kDomain : PictureLevel::kOutside;
      coarse.own[to] = static_cast<std::uint8_t>(count > 0 ? own / count : 0);
    }
  }
}

}  // namespace

void resize(PictureLevel& l, int width, int height) {
  l.width = width;
  l.height = height;
  const std::size_t size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  l.zone.resize(size);
  l.own.resize(size);
  l.value.resize(size);
  l.spans.resize(static_cast<std::size_t>(height));
}

void smooth(const PictureLevel& raw, PictureLevel& to, std::vector<float>& scratch) {
  resize(to, raw.width, raw.height);
  to.whole = raw.whole;
  to.zone = raw.zone;
  to.own = raw.own;
  filter<Smooth>(raw, to, scratch);
}

void halve(const PictureLevel& fine, PictureLevel& coarse, std::vector<float>& scratch) {
  resize(coarse, (fine.width + 1) / 2, (fine.height + 1) / 2);
  coarse.whole = fine.whole;
  halve_zones(fine, coarse);
  filter<Halve>(fine, coarse, scratch);
}

float mean_of_known(const PictureLevel& l, int index) {
  const int x = index % l.width, y = index / l.width;
  float sum = 0, count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, l.height - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, l.width - 1); ++u) {
      const std::size_t i = l.at(u, v);
      if (l.zone[i] == PictureLevel::kOutside) continue;
      sum += l.value[i];
      count += 1;
    }
  return sum / std::max(count, 1.F);
}

}  // namespace floatstage::render
