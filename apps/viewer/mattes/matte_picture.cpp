#include "apps/viewer/mattes/matte_picture.h"

#include <algorithm>
#include <cmath>

namespace floatstage::apps {
namespace {

constexpr int kSquare = 8;  // px of the chessboard
constexpr int kDark = 96, kLight = 160;

using Rgb = std::array<int, 3>;

template <class Color>
Image made(const Image& photograph, Color&& color) {
  Image out(photograph.width, photograph.height, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const Rgb c = color(x, y);
      for (int i = 0; i < 3; ++i)
        out.at(x, y)[i] = static_cast<std::uint8_t>(std::clamp(c[static_cast<std::size_t>(i)], 0, 255));
    }
  return out;
}

Rgb pixel(const Image& rgb, int x, int y) {
  const std::uint8_t* p = rgb.at(x, y);
  return {p[0], p[1], p[2]};
}

Image dimmed(const Image& photograph) {
  return made(photograph, [&](int x, int y) {
    const Rgb p = pixel(photograph, x, y);
    return Rgb{p[0] / 3, p[1] / 3, p[2] / 3};
  });
}

template <class Backdrop>
Image composed(const MatteViewInput& in, Backdrop&& backdrop) {
  return made(in.photograph, [&](int x, int y) {
    const int a = *in.matte.at(x, y);
    const Rgb p = pixel(in.photograph, x, y), b = backdrop(x, y);
    Rgb out;
    for (std::size_t i = 0; i < 3; ++i) out[i] = (a * p[i] + (255 - a) * b[i] + 127) / 255;
    return out;
  });
}

Image components_picture(const MatteViewInput& in) {
  const matting::MattingComponents& c = in.components;
  return made(in.photograph, [&](int x, int y) {
    const int cx = std::min(c.width - 1, x * c.width / in.photograph.width),
              cy = std::min(c.height - 1, y * c.height / in.photograph.height);
    const Rgb p = pixel(in.photograph, x, y);
    const double brightness = 0.35 + 0.65 * (p[0] + 2 * p[1] + p[2]) / 1020.0;
    double sum[3] = {};
    for (int k = 0; k < c.count(); ++k) {
      const std::array<std::uint8_t, 3> color = component_color(k);
      const double share = std::clamp(static_cast<double>(c.alpha(cy * c.width + cx, k)), 0.0, 1.0);
      for (int i = 0; i < 3; ++i) sum[i] += share * color[static_cast<std::size_t>(i)];
    }
    return Rgb{static_cast<int>(sum[0] * brightness), static_cast<int>(sum[1] * brightness),
               static_cast<int>(sum[2] * brightness)};
  });
}

// By how much each label covers a pixel, its colour takes the place of the photograph's, whose brightness
// stays; what of the matte is no label's becomes white, and the surroundings dark.
Image labels_picture(const MatteViewInput& in) {
  return made(in.photograph, [&](int x, int y) {
    const Rgb p = pixel(in.photograph, x, y);
    const int all = *in.matte.at(x, y);
    const double brightness = 0.35 + 0.65 * (p[0] + 2 * p[1] + p[2]) / 1020.0;
    double left = all, sum[3] = {};
    for (std::size_t l = 0; l < in.labels.size(); ++l) {
      if (in.labels[l].empty()) continue;
      const double share = std::min<double>(left, *in.labels[l].at(x, y));
      const std::array<std::uint8_t, 3> color = component_color(static_cast<int>(l));
      left -= share;
      for (std::size_t i = 0; i < 3; ++i) sum[i] += share * color[i];
    }
    Rgb out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = static_cast<int>(brightness * (sum[i] + 255 * left) / 255 + (255 - all) / 255.0 * p[i] / 3);
    return out;
  });
}

}  // namespace

const std::vector<std::string>& matte_view_names() {
  static const std::vector<std::string> names = {"photograph", "checker",    "colour", "matte",
                                                 "difference", "components", "labels"};
  return names;
}

std::array<std::uint8_t, 3> component_color(int component) {
  // Hues a golden angle apart: neighbours in number are far apart in colour.
  const double hue = std::fmod(component * 0.381966, 1.0) * 6;
  const double ramps[3] = {std::abs(hue - 3) - 1, 2 - std::abs(hue - 2), 2 - std::abs(hue - 4)};
  std::array<std::uint8_t, 3> out;
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(std::lround(40 + 215 * std::clamp(ramps[i], 0.0, 1.0)));
  return out;
}

Image matte_picture(MatteView view, const MatteViewInput& in) {
  const auto fits = [&](const Image& m) {
    return m.channels == 1 && m.width == in.photograph.width && m.height == in.photograph.height;
  };
  if (view == MatteView::Photograph) return in.photograph;
  if (view == MatteView::Components)
    return in.components.empty() ? dimmed(in.photograph) : components_picture(in);
  if (!fits(in.matte)) return dimmed(in.photograph);
  if (view == MatteView::Labels) {
    bool any = false;
    for (const Image& label : in.labels) {
      if (!label.empty() && !fits(label)) return dimmed(in.photograph);
      any = any || !label.empty();
    }
    return any ? labels_picture(in) : dimmed(in.photograph);
  }
  switch (view) {
    case MatteView::Checker:
      return composed(in, [](int x, int y) {
        const int v = (x / kSquare + y / kSquare) % 2 ? kLight : kDark;
        return Rgb{v, v, v};
      });
    case MatteView::Color:
      return composed(in, [&](int, int) { return Rgb{in.color[0], in.color[1], in.color[2]}; });
    case MatteView::Difference:
      return made(in.photograph, [&](int x, int y) {
        const int now = *in.matte.at(x, y), before = fits(in.before) ? *in.before.at(x, y) : now,
                  both = std::min(now, before) / 2;
        return Rgb{both + std::max(0, before - now), both + std::max(0, now - before), both};
      });
    default:
      return made(in.photograph, [&](int x, int y) {
        const int a = *in.matte.at(x, y);
        return Rgb{a, a, a};
      });
  }
}

}  // namespace floatstage::apps
