#include "detail/synthesis/color_grid.h"

#include <cmath>

namespace floatstage::detail {

ColorGrid to_colors(const Image& picture) {
  ColorGrid out(Region{0, 0, picture.width, picture.height});
  const auto channels = static_cast<std::size_t>(picture.channels);
  for (std::size_t i = 0; i < out.values.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      out.values[i][c] = static_cast<float>(picture.pixels[i * channels + c]);
  return out;
}

Image to_picture(const ColorGrid& colors) {
  Image out(colors.region.width(), colors.region.height(), 3);
  for (std::size_t i = 0; i < colors.values.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      out.pixels[3 * i + c] =
          static_cast<std::uint8_t>(std::lround(std::clamp(colors.values[i][c], 0.0F, 255.0F)));
  return out;
}

ColorGrid halved(const ColorGrid& fine) {
  ColorGrid out(halved(fine.region));
  for (int y = out.region.y0; y < out.region.y1; ++y)
    for (int x = out.region.x0; x < out.region.x1; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        out.at(x, y)[c] = (fine.nearest(2 * x, 2 * y)[c] + fine.nearest(2 * x + 1, 2 * y)[c] +
                           fine.nearest(2 * x, 2 * y + 1)[c] + fine.nearest(2 * x + 1, 2 * y + 1)[c]) /
                          4;
  return out;
}

ColorGrid refined(const ColorGrid& coarse, const Region& region) {
  constexpr float kNear = 22.0F / 128,
                  kFar = 3.0F / 128;  // of the differences of the next means, and of those beyond
  const auto off = [](const Color& a, const Color& b, const Color& d, const Color& e, std::size_t c) {
    return kNear * (d[c] - b[c]) - kFar * (e[c] - a[c]);
  };
  // Along y first, for the coarse columns that the region looks at.
  const Region cells = halved(region);
  const Region wide = common({cells.x0 - 2, 0, cells.x1 + 2, 0}, {coarse.region.x0, 0, coarse.region.x1, 0});
  ColorGrid rows(Region{wide.x0, region.y0, wide.x1, region.y1});
  for (int y = region.y0; y < region.y1; ++y) {
    const float side = y % 2 == 0 ? -1.0F : 1.0F;
    for (int x = wide.x0; x < wide.x1; ++x) {
      const Color &a = coarse.nearest(x, y / 2 - 2), &b = coarse.nearest(x, y / 2 - 1),
                  &here = coarse.nearest(x, y / 2), &d = coarse.nearest(x, y / 2 + 1),
                  &e = coarse.nearest(x, y / 2 + 2);
      for (std::size_t c = 0; c < 3; ++c) rows.at(x, y)[c] = here[c] + side * off(a, b, d, e, c);
    }
  }
  ColorGrid out(region);
  for (int y = region.y0; y < region.y1; ++y)
    for (int x = region.x0; x < region.x1; ++x) {
      const float side = x % 2 == 0 ? -1.0F : 1.0F;
      const Color &a = rows.nearest(x / 2 - 2, y), &b = rows.nearest(x / 2 - 1, y),
                  &here = rows.nearest(x / 2, y), &d = rows.nearest(x / 2 + 1, y),
                  &e = rows.nearest(x / 2 + 2, y);
      for (std::size_t c = 0; c < 3; ++c) out.at(x, y)[c] = here[c] + side * off(a, b, d, e, c);
    }
  return out;
}

}  // namespace floatstage::detail
