// Method:  the colours of subject and background, level by level from one pixel upwards
// Paper:   T. Germer, T. Uelwer, S. Conrad, S. Harmeling, "Fast multi-level foreground estimation", 2020,
//          eq. 4
// Differs: where the subject is absent its colour is the nearest subject's: layers scale without fringes
// ADR:     0101

#include "matting/foreground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/text.h"

namespace floatstage::matting {
namespace {

constexpr int kCoarse = 32;  // px: levels up to here are cheap and carry colour far
using Color = std::array<float, 3>;

// One level of the pyramid.
struct Level {
  int width = 0, height = 0;
  std::vector<Color> picture, foreground, background;
  std::vector<float> alpha;
  Level(int w, int h) : width(w), height(h) {
    const std::size_t n = static_cast<std::size_t>(w) * h;
    picture.resize(n), foreground.resize(n), background.resize(n), alpha.resize(n);
  }
};

// Area means of the full picture: every level straight from it, so that no error adds up.
void fill(const Image& picture, const Image& matte, Level& level) {
  for (int y = 0; y < level.height; ++y) {
    const int y0 = y * picture.height / level.height,
              y1 = std::max(y0 + 1, (y + 1) * picture.height / level.height);
    for (int x = 0; x < level.width; ++x) {
      const int x0 = x * picture.width / level.width,
                x1 = std::max(x0 + 1, (x + 1) * picture.width / level.width);
      long sum[4] = {};
      for (int v = y0; v < y1; ++v)
        for (int u = x0; u < x1; ++u) {
          for (int c = 0; c < 3; ++c) sum[c] += picture.at(u, v)[c];
          sum[3] += *matte.at(u, v);
        }
      const float scale = 1 / (255.0f * static_cast<float>((x1 - x0) * (y1 - y0)));
      const std::size_t p = static_cast<std::size_t>(y) * level.width + x;
      for (int c = 0; c < 3; ++c) level.picture[p][c] = static_cast<float>(sum[c]) * scale;
      level.alpha[p] = static_cast<float>(sum[3]) * scale;
    }
  }
}

void start_from(const Level& below, Level& level) {
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(y * below.height / level.height) * below.width +
                               x * below.width / level.width;
      const std::size_t p = static_cast<std::size_t>(y) * level.width + x;
      level.foreground[p] = below.foreground[from];
      level.background[p] = below.background[from];
    }
}

// One Gauss-Seidel sweep: both colours of a pixel from its neighbours', a 2x2 system with one matrix for all
// channels.
void sweep(const ForegroundOptions& options, Level& l) {
  for (int y = 0; y < l.height; ++y) {
    for (int x = 0; x < l.width; ++x) {
      const std::size_t p = static_cast<std::size_t>(y) * l.width + x;
      const float a = l.alpha[p];
      float total = 0;
      Color f{}, b{};
      const auto neighbour = [&](std::size_t q) {
        const float w = static_cast<float>(options.smooth) +
                        static_cast<float>(options.at_edges) * std::abs(a - l.alpha[q]);
        total += w;
        for (int c = 0; c < 3; ++c) f[c] += w * l.foreground[q][c], b[c] += w * l.background[q][c];
      };
      if (x > 0) neighbour(p - 1);
      if (x + 1 < l.width) neighbour(p + 1);
      if (y > 0) neighbour(p - static_cast<std::size_t>(l.width));
      if (y + 1 < l.height) neighbour(p + static_cast<std::size_t>(l.width));
      if (total == 0) continue;
      const float ff = a * a + total, bb = (1 - a) * (1 - a) + total, fb = a * (1 - a);
      const float scale =
          1 / (total * (a * a + (1 - a) * (1 - a) + total));  // the determinant, without cancellation
      for (int c = 0; c < 3; ++c) {
        const float right_f = a * l.picture[p][c] + f[c], right_b = (1 - a) * l.picture[p][c] + b[c];
        l.foreground[p][c] = std::clamp((bb * right_f - fb * right_b) * scale, 0.0f, 1.0f);
        l.background[p][c] = std::clamp((ff * right_b - fb * right_f) * scale, 0.0f, 1.0f);
      }
    }
  }
}

Image to_picture(const Level& level, const std::vector<Color>& colors) {
  Image out(level.width, level.height, 3);
  for (std::size_t p = 0; p < colors.size(); ++p)
    for (int c = 0; c < 3; ++c)
      out.pixels[3 * p + c] = static_cast<std::uint8_t>(std::lround(255 * colors[p][c]));
  return out;
}

}  // namespace

Result<Layers> estimate_foreground(const Image& picture, const Image& matte,
                                   const ForegroundOptions& options) {
  if (picture.channels != 3 || matte.channels != 1 || picture.width != matte.width ||
      picture.height != matte.height || picture.empty())
    return fail(
        ErrorCode::InvalidArgument,
        text("the foreground of a ", picture.width, "x", picture.height, " picture with ", picture.channels,
             " channels cannot be estimated with a matte of ", matte.width, "x", matte.height));
  Level level(1, 1);
  fill(picture, matte, level);
  level.foreground[0] = level.background[0] = level.picture[0];
  for (int w = 1, h = 1; w < picture.width || h < picture.height;) {
    w = std::min(2 * w, picture.width);
    h = std::min(2 * h, picture.height);
    Level next(w, h);
    fill(picture, matte, next);
    start_from(level, next);
    const int steps = std::max(w, h) <= kCoarse ? options.coarse_steps : options.fine_steps;
    for (int i = 0; i < steps; ++i) sweep(options, next);
    level = std::move(next);
  }
  return Layers{to_picture(level, level.foreground), to_picture(level, level.background)};
}

void despill(Image& rgb, BackingChannel channel, double average, bool keep_luma) {
  FLOATSTAGE_CHECK(rgb.channels == 3, "spill is taken off RGB pictures");
  constexpr float kLuma[3] = {0.299f, 0.587f, 0.114f};
  const int k = static_cast<int>(channel), i = (k + 1) % 3, j = (k + 2) % 3;
  const float mix = static_cast<float>(average);
  for (std::uint8_t* p = rgb.pixels.data(); p != rgb.pixels.data() + rgb.pixels.size(); p += 3) {
    const float most = std::max(p[i], p[j]), mean = 0.5f * static_cast<float>(p[i] + p[j]);
    const int limit = static_cast<int>((1 - mix) * most + mix * mean + 0.5f);
    if (p[k] <= limit) continue;
    const float lost = kLuma[k] * static_cast<float>(p[k] - limit);
    p[k] = static_cast<std::uint8_t>(limit);
    if (!keep_luma) continue;
    for (int c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(std::min(255.0f, p[c] + lost + 0.5f));
  }
}

}  // namespace floatstage::matting
