// The extended dependency graph (M. Eisemann, "Error-Concealed Image-Based Rendering", 4.4.1): the pyramid of
// every close photograph, aligned with the output's levels. Different: beside colours a level holds what it
// adds to the coarser one (docs/adr/0248).

#include "detail/synthesis/exemplars.h"

#include <cmath>

#include "core/parallel.h"

namespace floatstage::detail {
namespace {

constexpr float kOpaque = 0.999F;
// Of a composed photograph that fades in from its seam (Eq. 4.7): from here on its details are used whole,
// since a level's means are the root's anyway (docs/constants.md).
constexpr std::uint8_t kUsed = 85;
constexpr float kMeanCounts = 0.5F;  // of a neighbourhood's colour, beside its structure

// Rounded down and up to multiples of a power of two.
Region aligned(const Region& r, int side) {
  const auto down = [&](int v) { return v & ~(side - 1); };
  return {down(r.x0), down(r.y0), down(r.x1 + side - 1), down(r.y1 + side - 1)};
}

// Means of what is opaque, and of opacity.
void halve(const ColorGrid& colors, const Grid<float>& opacity, ColorGrid& to_colors,
           Grid<float>& to_opacity) {
  to_colors = ColorGrid(halved(colors.region));
  to_opacity = Grid<float>(to_colors.region);
  for (int y = to_colors.region.y0; y < to_colors.region.y1; ++y)
    for (int x = to_colors.region.x0; x < to_colors.region.x1; ++x) {
      float sum = 0;
      Color mean{};
      for (int i = 0; i < 4; ++i) {
        const int u = 2 * x + i % 2, v = 2 * y + i / 2;
        const float o = opacity.at(u, v);
        sum += o;
        for (std::size_t c = 0; c < 3; ++c) mean[c] += o * colors.at(u, v)[c];
      }
      to_opacity.at(x, y) = sum / 4;
      for (std::size_t c = 0; c < 3; ++c) to_colors.at(x, y)[c] = sum > 0 ? mean[c] / sum : 0;
    }
}

// Where nothing is opaque, the mean of opaque pixels beside: refined() looks one pixel beyond what is used.
void spread(ColorGrid& colors, const Grid<float>& opacity) {
  const Region& r = opacity.region;
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x) {
      if (opacity.at(x, y) > 0) continue;
      const Region around = common({x - 1, y - 1, x + 2, y + 2}, r);
      Color sum{};
      float count = 0;
      for (int v = around.y0; v < around.y1; ++v)
        for (int u = around.x0; u < around.x1; ++u) {
          if (opacity.at(u, v) == 0) continue;
          ++count;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += colors.at(u, v)[c];
        }
      for (std::size_t c = 0; c < 3 && count > 0; ++c) colors.at(x, y)[c] = sum[c] / count;
    }
}

// Opacity rises from a layer's border over kRim pixels of every level, the fine details' over less of the
// picture than the coarse ones' (P. Burt and E. Adelson, 1983): what stands beside it is not cut off.
void soften(Grid<float>& opacity) {
  constexpr int kRim = 8;
  const Region& r = opacity.region;
  Grid<int> depth(r, kRim + 1);  // in moves of a king from what is not opaque
  const auto at = [&](int x, int y) { return r.contains(x, y) ? depth.at(x, y) : 0; };
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x)
      depth.at(x, y) =
          opacity.at(x, y) < kOpaque
              ? 0
              : std::min(kRim + 1,
                         1 + std::min({at(x - 1, y), at(x - 1, y - 1), at(x, y - 1), at(x + 1, y - 1)}));
  for (int y = r.y1 - 1; y >= r.y0; --y)
    for (int x = r.x1 - 1; x >= r.x0; --x)
      depth.at(x, y) = std::min(
          depth.at(x, y), 1 + std::min({at(x + 1, y), at(x + 1, y + 1), at(x, y + 1), at(x - 1, y + 1)}));
  for (std::size_t i = 0; i < depth.values.size(); ++i)
    opacity.values[i] *= static_cast<float>(depth.values[i]) / (kRim + 1);
}

}  // namespace

LayerPyramid::LayerPyramid(const DetailLayer& layer, int levels)
    : levels_(static_cast<std::size_t>(levels) + 1),
      finest_(std::min(layer.level, levels)),
      moved_(layer.moved) {
  const Region own{layer.x, layer.y, layer.x + layer.picture.width, layer.y + layer.picture.height};
  Level& top = levels_.back();
  top.colors = ColorGrid(aligned(own, 1 << levels));
  top.opacity = Grid<float>(top.colors.region, 0);
  for (int y = own.y0; y < own.y1; ++y)
    for (int x = own.x0; x < own.x1; ++x) {
      const std::uint8_t* from = layer.picture.at(x - own.x0, y - own.y0);
      top.opacity.at(x, y) = from[3] >= kUsed ? 1 : 0;
      for (std::size_t c = 0; c < 3; ++c) top.colors.at(x, y)[c] = from[c];
    }
  for (std::size_t t = levels_.size() - 1; t > 0; --t)
    halve(levels_[t].colors, levels_[t].opacity, levels_[t - 1].colors, levels_[t - 1].opacity);
  for (Level& level : levels_) {
    spread(level.colors, level.opacity);
    level.whole = Grid<std::uint8_t>(level.opacity.region, 0);
    for (std::size_t i = 0; i < level.whole.values.size(); ++i)
      level.whole.values[i] = level.opacity.values[i] > kOpaque;
    soften(level.opacity);
  }
}

Exemplars::Exemplars(const std::vector<LayerPyramid>& layers, int levels, std::size_t most, int threads) {
  const int side = 1 << levels;
  // Where every layer goes; a row of level 0 between two.
  const double share = static_cast<double>(most) / std::max<std::size_t>(1, layers.size());
  int width = 0, height = 0;
  for (const LayerPyramid& layer : layers) {
    Region from = layer.colors(levels).region;
    const double area = static_cast<double>(from.width()) * from.height();
    if (area > share) {
      const double keep = std::sqrt(share / area);
      const int w = static_cast<int>(from.width() * (1 - keep) / 2),
                h = static_cast<int>(from.height() * (1 - keep) / 2);
      from = aligned({from.x0 + w, from.y0 + h, from.x1 - w, from.y1 - h}, side);
    }
    parts_.push_back({from, 0, height});
    width = std::max(width, from.width());
    height += from.height() + side;
  }
  levels_.resize(static_cast<std::size_t>(levels) + 1);
  if (layers.empty()) return;
  std::vector<ColorGrid> colors(levels_.size());
  std::vector<Grid<std::uint8_t>> covered(levels_.size());
  for (int t = 0; t <= levels; ++t) {
    const int down = levels - t;
    const Region whole{0, 0, width >> down, height >> down};
    ColorGrid& to = colors[static_cast<std::size_t>(t)];
    Grid<std::uint8_t>& cover = covered[static_cast<std::size_t>(t)];
    to = ColorGrid(whole);
    cover = Grid<std::uint8_t>(whole, 0);
    if (t > 0) levels_[static_cast<std::size_t>(t)].detail = ColorGrid(whole);
    for (std::size_t i = 0; i < layers.size(); ++i) {
      const Region from{parts_[i].from.x0 >> down, parts_[i].from.y0 >> down, parts_[i].from.x1 >> down,
                        parts_[i].from.y1 >> down};
      const ColorGrid base = t > 0 ? refined(layers[i].colors(t - 1), from) : ColorGrid();
      const int dx = (parts_[i].x >> down) - from.x0, dy = (parts_[i].y >> down) - from.y0;
      for (int y = from.y0; y < from.y1; ++y)
        for (int x = from.x0; x < from.x1; ++x) {
          const Color& here = to.at(x + dx, y + dy) = layers[i].colors(t).at(x, y);
          for (std::size_t c = 0; c < 3 && t > 0; ++c)
            levels_[static_cast<std::size_t>(t)].detail.at(x + dx, y + dy)[c] = here[c] - base.at(x, y)[c];
          cover.at(x + dx, y + dy) = t <= layers[i].finest() && layers[i].covers(t, x, y);
        }
    }
  }
  parallel_for(levels_.size(), threads, [&](std::size_t i) {
    const int t = static_cast<int>(i);
    Level& l = levels_[i];
    l.width = colors[i].region.width();
    l.height = colors[i].region.height();
    l.usable = Grid<std::uint8_t>(colors[i].region, 0);
    // A level's neighbourhood lies within 3 x 3 pixels of the coarser one.
    const Grid<std::uint8_t>& cover = covered[t == 0 ? 0 : i - 1];
    const int reach = t == 0 ? Neighbourhoods::kReach : 1;
    for (int y = 0; y < l.height; ++y)
      for (int x = 0; x < l.width; ++x) {
        const int u = t == 0 ? x : x / 2, v = t == 0 ? y : y / 2;
        bool whole = covered[i].at(x, y);
        for (int b = v - reach; b <= v + reach && whole; ++b)
          for (int a = u - reach; a <= u + reach && whole; ++a)
            whole = cover.region.contains(a, b) && cover.at(a, b);
        l.usable.at(x, y) = whole;
      }
  });
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    Level& l = levels_[i];
    if (std::find(l.usable.values.begin(), l.usable.values.end(), 1) == l.usable.values.end()) continue;
    l.basis = Neighbourhoods(colors[i], l.usable, kMeanCounts);
    const auto d = static_cast<std::size_t>(l.basis.dimensions());
    l.features.assign(l.usable.values.size() * d, 0);
    parallel_for(static_cast<std::size_t>(l.height), threads, [&](std::size_t y) {
      for (int x = 0; x < l.width; ++x)
        if (l.usable.at(x, static_cast<int>(y)))
          l.basis.project(colors[i], x, static_cast<int>(y),
                          &l.features[l.usable.index(x, static_cast<int>(y)) * d]);
    });
  }
  parallel_for(levels_.size() - 1, threads, [&](std::size_t i) {
    Level& l = levels_[i];
    const auto d = static_cast<std::size_t>(std::max(1, l.basis.dimensions()));
    std::vector<float> points;
    for (std::size_t p = 0; p < l.usable.values.size(); ++p) {
      if (!l.usable.values[p]) continue;
      // What has no next level brings no details.
      const Grid<std::uint8_t>& finer = levels_[i + 1].usable;
      const int x = static_cast<int>(p % static_cast<std::size_t>(l.width)),
                y = static_cast<int>(p / static_cast<std::size_t>(l.width));
      if (!finer.at(2 * x, 2 * y) || !finer.at(2 * x + 1, 2 * y + 1)) continue;
      l.tree_places.push_back(static_cast<Place>(p));
      points.insert(points.end(), l.features.begin() + static_cast<std::ptrdiff_t>(p * d),
                    l.features.begin() + static_cast<std::ptrdiff_t>((p + 1) * d));
    }
    l.tree = NearestPoints(points, static_cast<int>(d));
  });
}

Exemplars::Place Exemplars::place_of(std::size_t layer, int level, int x, int y) const {
  const int down = static_cast<int>(levels_.size()) - 1 - level;
  const Part& part = parts_[layer];
  const int u = x - (part.from.x0 >> down), v = y - (part.from.y0 >> down);
  const Level& l = levels_[static_cast<std::size_t>(level)];
  if (u < 0 || v < 0 || u >= part.from.width() >> down || v >= part.from.height() >> down) return kNowhere;
  return shifted(level, static_cast<Place>(l.usable.index(u + (part.x >> down), v + (part.y >> down))), 0, 0);
}

Exemplars::Place Exemplars::shifted(int level, Place place, int dx, int dy) const {
  if (place == kNowhere) return kNowhere;
  const Level& l = levels_[static_cast<std::size_t>(level)];
  const int x = static_cast<int>(place % static_cast<Place>(l.width)) + dx,
            y = static_cast<int>(place / static_cast<Place>(l.width)) + dy;
  if (x < 0 || y < 0 || x >= l.width || y >= l.height || !l.usable.at(x, y)) return kNowhere;
  return static_cast<Place>(l.usable.index(x, y));
}

}  // namespace floatstage::detail
