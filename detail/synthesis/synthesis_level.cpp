// Constrained multiscale detail synthesis (M. Eisemann, "Error-Concealed Image-Based Rendering", 4.4.2):
// coordinates are refined from level to level and optimised by comparing 5 x 5 neighbourhoods, each pixel
// choosing among the shifted matches of its neighbours (S. Lefebvre and H. Hoppe, "Parallel Controllable
// Texture Synthesis", 2005; X. Tong et al., 2002). Different: a pixel takes from its exemplar what the level
// adds to the coarser one, not the colour, so that means over 2 x 2 pixels stay those of the coarser level
// (docs/adr/0248).

#include "detail/synthesis/synthesis_level.h"

#include <cmath>
#include <limits>

#include "core/check.h"

namespace floatstage::detail {
namespace {

constexpr int kFound = 3;  // nearest neighbourhoods, the thesis' n
constexpr int kMatches = kFound + 1;
constexpr float kOpaque = 0.999F;

using Matches = std::array<Exemplars::Place, kMatches>;

}  // namespace

struct SynthesisLevel::Work {
  const Exemplars::Level* coarser;
  const Exemplars::Level* here;
  Region all;             // what is worked on
  Grid<Matches> matches;  // of coarse pixels, at the coarser level
  ColorGrid base;         // the coarser level, refined
  ColorGrid colors;
  Grid<Place> places, next;
  Grid<std::uint8_t> covered;  // 1: a layer's own pixel, which stays
  Grid<float> opacity;         // of layers
  ColorGrid layer;             // their colours
  Grid<std::uint8_t> provenance;
};

// What has to be there so that `iterations` more give `wanted`: whole cells of 2 x 2, whose means are kept.
Region SynthesisLevel::worked_on(const Region& wanted, int iterations) const {
  return grown(doubled(halved(wanted)), 2 * iterations, s_.whole(level_));
}

Region SynthesisLevel::needed(const Region& wanted) const {
  return grown(halved(worked_on(wanted, s_.options_.iterations)), 1 + Neighbourhoods::kReach,
               s_.whole(level_ - 1));
}

// Of what a layer shows, the layer's own place. Else where the coarser level's details came from, whose finer
// ones go with them; and the nearest neighbourhoods there are. The finest level looks for none: most of the
// work would be there, and what is found is nearly always what was carried on.
void SynthesisLevel::find_matches(Work& w, const SynthesisTile& coarse) const {
  w.matches = Grid<Matches>(grown(halved(w.all), 1, s_.whole(level_ - 1)));
  std::array<float, Neighbourhoods::kMost> feature{};
  const Region& r = w.matches.region;
  for (int y = r.y0; y < r.y1; ++y)
    for (int x = r.x0; x < r.x1; ++x) {
      Matches& m = w.matches.at(x, y);
      m.fill(Exemplars::kNowhere);
      for (std::size_t i = 0; i < s_.layers_.size(); ++i)
        if (s_.layers_[i].finest() >= level_ && s_.layers_[i].covers(level_ - 1, x, y))
          m[0] = s_.exemplars_->place_of(i, level_ - 1, x, y);
      if (m[0] != Exemplars::kNowhere || w.coarser->tree.count() == 0) continue;
      std::size_t known = 0;
      const Place carried = coarse.places.at(x, y);
      if (carried != Exemplars::kNowhere && w.coarser->usable.values[carried]) m[known++] = carried;
      if (known > 0 && level_ == s_.options_.levels) continue;
      w.coarser->basis.project(coarse.colors, x, y, feature.data());
      std::array<NearestPoints::Found, kFound> found;
      const auto count = static_cast<std::size_t>(
          w.coarser->tree.find(feature.data(), kFound, s_.options_.slack, found.data()));
      for (std::size_t k = 0; k < count; ++k) m[known + k] = w.coarser->tree_places[found[k].index];
    }
}

void SynthesisLevel::place_layers(Work& w) const {
  w.opacity = Grid<float>(w.all, 0);
  w.layer = ColorGrid(w.all);
  w.covered = Grid<std::uint8_t>(w.all, 0);
  w.provenance = Grid<std::uint8_t>(w.all, static_cast<std::uint8_t>(Provenance::Upsampled));
  for (std::size_t i = 0; i < s_.layers_.size(); ++i) {
    const LayerPyramid& layer = s_.layers_[i];
    if (layer.finest() < level_) continue;
    const Region r = common(w.all, layer.colors(level_).region);
    for (int y = r.y0; y < r.y1; ++y)
      for (int x = r.x0; x < r.x1; ++x) {
        const float o = layer.opacity(level_, x, y);
        if (o == 0) continue;
        const Color& c = layer.colors(level_).at(x, y);
        Color& to = w.layer.at(x, y);
        float& below = w.opacity.at(x, y);
        const float together = o + (1 - o) * below;
        for (std::size_t k = 0; k < 3; ++k) to[k] = (o * c[k] + (1 - o) * below * to[k]) / together;
        below = together;
        const bool whole = o > kOpaque;
        w.provenance.at(x, y) =
            static_cast<std::uint8_t>(whole && !layer.moved() ? Provenance::Real : Provenance::Warped);
        if (!whole) continue;
        w.covered.at(x, y) = 1;
        w.places.at(x, y) = s_.exemplars_->place_of(i, level_, x, y);
      }
  }
}

// The base and the details, whose means over 2 x 2 pixels are taken out; over them the layers.
void SynthesisLevel::color(Work& w, const Region& region) const {
  const Region cells = halved(region);
  for (int y = cells.y0; y < cells.y1; ++y)
    for (int x = cells.x0; x < cells.x1; ++x) {
      std::array<Color, 4> detail{};
      for (std::size_t i = 0; i < 4; ++i) {
        const Place p = w.places.at(2 * x + static_cast<int>(i % 2), 2 * y + static_cast<int>(i / 2));
        if (p != Exemplars::kNowhere) detail[i] = w.here->detail.values[p];
      }
      const Strengths::Gains gains = s_.strengths_->gains(level_, x, y, w.places.at(2 * x, 2 * y));
      for (std::size_t c = 0; c < 3; ++c) {
        const float a = detail[0][c], b = detail[1][c], d = detail[2][c], e = detail[3][c];
        const float across = gains[0] * (a - b + d - e) / 4, down = gains[1] * (a + b - d - e) / 4,
                    cross = gains[2] * (a - b - d + e) / 4;
        detail[0][c] = across + down + cross;
        detail[1][c] = down - across - cross;
        detail[2][c] = across - down - cross;
        detail[3][c] = cross - across - down;
      }
      for (std::size_t i = 0; i < 4; ++i) {
        const int u = 2 * x + static_cast<int>(i % 2), v = 2 * y + static_cast<int>(i / 2);
        const float o = w.opacity.at(u, v);
        const Color &base = w.base.at(u, v), &layer = w.layer.at(u, v);
        Color& to = w.colors.at(u, v);
        for (std::size_t c = 0; c < 3; ++c) to[c] = o * layer[c] + (1 - o) * (base[c] + detail[i][c]);
      }
    }
}

// The M-step: of what its neighbours' matches would put here, the neighbourhood that is nearest.
SynthesisLevel::Place SynthesisLevel::best_candidate(const Work& w, int x, int y, bool first) const {
  std::array<float, Neighbourhoods::kMost> feature{};
  w.here->basis.project(w.colors, x, y, feature.data());
  const auto d = static_cast<std::size_t>(w.here->basis.dimensions());
  Place best = w.places.at(x, y);
  float least = std::numeric_limits<float>::max();
  const auto compare = [&](Place candidate) {
    if (candidate == Exemplars::kNowhere) return;
    const float* other = w.here->feature(candidate);
    float sum = 0;
    for (std::size_t k = 0; k < d; ++k) sum += (feature[k] - other[k]) * (feature[k] - other[k]);
    if (sum < least || (sum == least && candidate < best)) {
      least = sum;
      best = candidate;
    }
  };
  const auto width = static_cast<Place>(w.coarser->width);
  // A match of a coarse pixel, as many fine pixels further as this pixel is from that one's first.
  const auto compare_matches = [&](int u, int v) {
    if (!w.matches.region.contains(u, v)) return;
    Place before = Exemplars::kNowhere;
    for (const Place m : w.matches.at(u, v)) {
      if (m == Exemplars::kNowhere || m == before) continue;
      before = m;
      const int a = 2 * static_cast<int>(m % width) + x - 2 * u,
                b = 2 * static_cast<int>(m / width) + y - 2 * v;
      const Grid<std::uint8_t>& usable = w.here->usable;
      if (usable.region.contains(a, b) && usable.at(a, b)) compare(static_cast<Place>(usable.index(a, b)));
    }
  };
  const int u = x / 2, v = y / 2;
  if (first) {
    const int other_u = x % 2 == 0 ? u - 1 : u + 1, other_v = y % 2 == 0 ? v - 1 : v + 1;
    compare_matches(u, v);
    compare_matches(other_u, v);
    compare_matches(u, other_v);
    compare_matches(other_u, other_v);
    return best;
  }
  compare_matches(u, v);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if (w.places.region.contains(x + dx, y + dy))
        compare(s_.exemplars_->shifted(level_, w.places.at(x + dx, y + dy), -dx, -dy));
  return best;
}

void SynthesisLevel::improve(Work& w, const Region& region, bool first) const {
  w.next = w.places;
  for (int y = region.y0; y < region.y1; ++y)
    for (int x = region.x0; x < region.x1; ++x)
      if (!w.covered.at(x, y) && w.here->basis.dimensions() > 0)
        w.next.at(x, y) = best_candidate(w, x, y, first);
  std::swap(w.next, w.places);
}

SynthesisTile SynthesisLevel::make(const Region& wanted, const SynthesisTile& coarse) const {
  FLOATSTAGE_CHECK(coarse.region.contains(needed(wanted)), "the coarser level is too small");
  Work w;
  w.coarser = &s_.exemplars_->level(level_ - 1);
  w.here = &s_.exemplars_->level(level_);
  w.all = worked_on(wanted, s_.options_.iterations);
  find_matches(w, coarse);
  w.base = refined(coarse.colors, w.all);
  w.colors = ColorGrid(w.all);
  w.places = Grid<Place>(w.all, Exemplars::kNowhere);
  const auto width = static_cast<Place>(w.coarser->width), fine_width = static_cast<Place>(w.here->width);
  for (int y = w.all.y0; y < w.all.y1; ++y)
    for (int x = w.all.x0; x < w.all.x1; ++x) {
      const Place m = w.matches.at(x / 2, y / 2)[0];
      if (m != Exemplars::kNowhere)
        w.places.at(x, y) = (2 * (m / width) + static_cast<Place>(y % 2)) * fine_width + 2 * (m % width) +
                            static_cast<Place>(x % 2);
    }
  place_layers(w);
  color(w, w.all);
  for (int i = 0; i < s_.options_.iterations; ++i) {
    const Region r = worked_on(wanted, s_.options_.iterations - 1 - i);
    improve(w, r, i == 0);
    color(w, r);
  }
  SynthesisTile out{wanted, ColorGrid(wanted), Grid<std::uint8_t>(wanted), Grid<Place>(wanted)};
  for (int y = wanted.y0; y < wanted.y1; ++y)
    for (int x = wanted.x0; x < wanted.x1; ++x) {
      out.colors.at(x, y) = w.colors.at(x, y);
      out.places.at(x, y) = w.places.at(x, y);
      std::uint8_t& from = out.provenance.at(x, y) = w.provenance.at(x, y);
      if (from == static_cast<std::uint8_t>(Provenance::Upsampled) &&
          w.places.at(x, y) != Exemplars::kNowhere)
        from = static_cast<std::uint8_t>(Provenance::Synthesised);
    }
  return out;
}

}  // namespace floatstage::detail
