#include "matting/doubt_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "matting/view_cut.h"

namespace floatstage::matting {
namespace {

constexpr int kGap = 4;  // px between tiles
constexpr std::array<std::uint8_t, 3> kRed{255, 40, 40}, kBlue{80, 200, 255};

bool is(const Image& matte, int x, int y) {
  return x >= 0 && y >= 0 && x < matte.width && y < matte.height && *matte.at(x, y) >= 128;
}

// Two pixels wide: those within, and their neighbours outside.
void draw_outline(const Image& matte, const std::array<std::uint8_t, 3>& color, Image& out) {
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const bool here = is(matte, x, y);
      if (is(matte, x - 1, y) != here || is(matte, x + 1, y) != here || is(matte, x, y - 1) != here ||
          is(matte, x, y + 1) != here)
        std::copy(color.begin(), color.end(), out.at(x, y));
    }
}

}  // namespace

Image doubt_tile(const Image& rgb, const Matte& matte, const std::optional<Matte>& others, int longest) {
  const double scale = std::min(1.0, static_cast<double>(longest) / std::max(rgb.width, rgb.height));
  const int w = std::max(1, static_cast<int>(std::lround(scale * rgb.width))),
            h = std::max(1, static_cast<int>(std::lround(scale * rgb.height)));
  Image out = shrunk(rgb, w, h);
  const Image small = shrunk(to_image(matte), w, h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (!is(small, x, y))
        for (int c = 0; c < 3; ++c) out.at(x, y)[c] = static_cast<std::uint8_t>(out.at(x, y)[c] / 3);
  draw_outline(small, kRed, out);
  if (others) draw_outline(shrunk(to_image(*others), w, h), kBlue, out);
  return out;
}

Image contact_sheet(const std::vector<Image>& tiles) {
  if (tiles.empty()) return {};
  int w = 0, h = 0;
  for (const Image& t : tiles) w = std::max(w, t.width), h = std::max(h, t.height);
  const int count = static_cast<int>(tiles.size());
  const int across =
      std::clamp(static_cast<int>(std::lround(std::sqrt(static_cast<double>(count) * h / w))), 1, count);
  const int down = (count + across - 1) / across;
  Image sheet(across * (w + kGap) - kGap, down * (h + kGap) - kGap, 3);
  for (int i = 0; i < count; ++i) {
    const Image& t = tiles[static_cast<std::size_t>(i)];
    for (int y = 0; y < t.height; ++y)
      std::copy_n(t.at(0, y), static_cast<std::size_t>(3 * t.width),
                  sheet.at((i % across) * (w + kGap), (i / across) * (h + kGap) + y));
  }
  return sheet;
}

}  // namespace floatstage::matting
