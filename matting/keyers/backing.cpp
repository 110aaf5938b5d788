#include "matting/keyers/backing.h"

#include <algorithm>
#include <array>

namespace floatstage::matting {
namespace {

constexpr int kBins = 64;           // a side of the (r, b) chromaticity histogram
constexpr int kBorderShare = 6;     // the border is a sixth of the picture on each side
constexpr int kDarkest = 60;        // r + g + b: below, chromaticity is noise
constexpr double kMinShare = 0.02;  // of the border's pixels

struct Bin {
  std::int64_t count = 0, r = 0, g = 0, b = 0;
  void add(const Bin& o) { count += o.count, r += o.r, g += o.g, b += o.b; }
};

// Green or blue leads by a quarter. (Skin, wood and warm light lead in red.)
bool looks_like_cloth(int r, int g, int b) {
  if (r + g + b < kDarkest) return false;
  return g >= b ? 4 * g > 5 * std::max(r, b) : 4 * b > 5 * std::max(r, g);
}

}  // namespace

BackingChannel backing_channel(Rgb color) {
  return color.b > color.g ? BackingChannel::Blue : BackingChannel::Green;
}

std::optional<Rgb> sample_backing(const std::vector<Image>& pictures) {
  std::vector<Bin> bins(kBins * kBins);
  std::int64_t seen = 0;
  for (const Image& picture : pictures) {
    const int border_x = picture.width / kBorderShare, border_y = picture.height / kBorderShare;
    for (int y = 0; y < picture.height; ++y) {
      const bool all = y < border_y || y >= picture.height - border_y;
      for (int x = 0; x < picture.width; ++x) {
        if (!all && x >= border_x && x < picture.width - border_x) continue;
        const std::uint8_t* p = picture.at(x, y);
        ++seen;
        if (!looks_like_cloth(p[0], p[1], p[2])) continue;
        const int sum = p[0] + p[1] + p[2];
        bins[static_cast<std::size_t>(p[0] * kBins / (sum + 1) * kBins + p[2] * kBins / (sum + 1))].add(
            {1, p[0], p[1], p[2]});
      }
    }
  }
  // The mode is taken over 3x3 bins, so that a cloth that straddles a bin's edge still wins.
  Bin mode;
  for (int i = 1; i + 1 < kBins; ++i) {
    for (int j = 1; j + 1 < kBins; ++j) {
      Bin sum;
      for (int di = -1; di <= 1; ++di)
        for (int dj = -1; dj <= 1; ++dj) sum.add(bins[static_cast<std::size_t>((i + di) * kBins + j + dj)]);
      if (sum.count > mode.count) mode = sum;
    }
  }
  if (mode.count == 0 || static_cast<double>(mode.count) < kMinShare * static_cast<double>(seen))
    return std::nullopt;
  auto mean = [&](std::int64_t total) {
    return static_cast<std::uint8_t>((total + mode.count / 2) / mode.count);
  };
  return Rgb{mean(mode.r), mean(mode.g), mean(mode.b)};
}

}  // namespace floatstage::matting
