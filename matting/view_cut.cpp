#include "matting/view_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "core/check.h"
#include "core/graph_cut.h"
#include "matting/picture_scale.h"
#include "matting/tone.h"

namespace floatstage::matting {
namespace {

constexpr float kUnit = 1000;     // whole steps of the cut, which keep it exact
constexpr float kFloor = 0.05f;   // of the smoothness: edges are never for nothing
constexpr float kCertain = 1000;  // log-odds
constexpr double kCalm = 2;       // noise deviations below which a step is no edge
constexpr double kGradual = 6;    // 8-bit steps over three channels: light that changes, not an edge
constexpr double kGeodesicPixels = 20'000;

struct Step {
  int dx, dy;
  float length;
};
constexpr Step kSteps[] = {{1, 0, 1}, {0, 1, 1}, {1, 1, 1.41421356f}, {-1, 1, 1.41421356f}};

std::size_t pixels(const Image& picture) {
  return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

const std::uint8_t* colour(const Image& picture, std::size_t p) { return picture.pixels.data() + 3 * p; }

Image toned(const Image& picture) {
  Image out = picture;
  for (std::uint8_t& v : out.pixels) v = tone()[v];
  return out;
}

float squared(const std::uint8_t* a, const std::uint8_t* b) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) sum += static_cast<float>((a[c] - b[c]) * (a[c] - b[c]));
  return sum;
}

// Of what two pixels have become, from what they were.
float squared_change(const std::uint8_t* a, const std::uint8_t* a_was, const std::uint8_t* b,
                     const std::uint8_t* b_was) {
  float sum = 0;
  for (int c = 0; c < 3; ++c) {
    const int d = a[c] - a_was[c] - (b[c] - b_was[c]);
    sum += static_cast<float>(d * d);
  }
  return sum;
}

int difference(const std::uint8_t* a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

int whole(float v) { return static_cast<int>(std::lround(kUnit * v)); }

// Calls what(p, q, length) for every pair of 8-neighbours.
template <class What>
void each_pair(const Image& picture, const What& what) {
  const int w = picture.width, h = picture.height;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (const Step& s : kSteps) {
        if (x + s.dx < 0 || x + s.dx >= w || y + s.dy >= h) continue;
        what(static_cast<std::size_t>(y) * w + x,
             static_cast<std::size_t>(y + s.dy) * w + static_cast<std::size_t>(x + s.dx), s.length);
      }
}

}  // namespace

Image shrunk(const Image& picture, int width, int height) { return scaled(picture, width, height); }

double noise_of(const Image& picture) {
  std::array<long, 3 * 255 + 1> counts{};
  long total = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x + 1 < picture.width; ++x, ++total)
      ++counts[static_cast<std::size_t>(difference(picture.at(x, y), picture.at(x + 1, y)))];
  std::size_t median = 0;
  for (long seen = 0; median < counts.size() && 2 * (seen += counts[median]) < total;) ++median;
  return std::max(1.0, static_cast<double>(median) / (std::sqrt(2.0) * 0.6745));
}

std::vector<float> edges_to_border(const Image& photograph) {
  // At a small size edges are a pixel wide, and noise has averaged away.
  const double shrink = std::min(1.0, std::sqrt(kGeodesicPixels / static_cast<double>(pixels(photograph))));
  const auto small = [&](int side) { return std::max(1, static_cast<int>(std::lround(side * shrink))); };
  const Image plain = scaled(photograph, small(photograph.width), small(photograph.height)),
              picture = toned(plain);
  const int w = picture.width, h = picture.height;
  using Item = std::pair<float, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  std::vector<float> distance(pixels(picture), 1e9f);
  const double calm = std::max(kGradual, kCalm * noise_of(plain));
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (x == 0 || y == 0 || x == w - 1 || y == h - 1) {
        distance[static_cast<std::size_t>(y) * w + x] = 0;
        queue.push({0, y * w + x});
      }
  while (!queue.empty()) {
    const auto [so_far, p] = queue.top();
    queue.pop();
    if (so_far > distance[static_cast<std::size_t>(p)]) continue;
    const int x = p % w, y = p / w;
    for (int qy = std::max(0, y - 1); qy <= std::min(h - 1, y + 1); ++qy)
      for (int qx = std::max(0, x - 1); qx <= std::min(w - 1, x + 1); ++qx) {
        const bool edge = difference(plain.at(x, y), plain.at(qx, qy)) > calm;
        const float there =
            so_far + (edge ? static_cast<float>(difference(picture.at(x, y), picture.at(qx, qy))) : 0);
        float& best = distance[static_cast<std::size_t>(qy) * w + qx];
        if (there >= best) continue;
        best = there;
        queue.push({there, qy * w + qx});
      }
  }
  std::vector<float> out(pixels(photograph));
  for (std::size_t p = 0; p < out.size(); ++p) {
    const auto x = static_cast<int>(p) % photograph.width, y = static_cast<int>(p) / photograph.width;
    out[p] = distance[static_cast<std::size_t>(y * h / photograph.height) * static_cast<std::size_t>(w) +
                      static_cast<std::size_t>(x * w / photograph.width)];
  }
  return out;
}

Image cut_view(const Image& photograph, std::span<const float> odds, std::span<const Certain> certain,
               double smooth, const Image& empty_stage, std::span<const std::uint8_t> shadow) {
  FLOATSTAGE_CHECK(photograph.channels == 3 && odds.size() == pixels(photograph) &&
                       (certain.empty() || certain.size() == odds.size()) &&
                       (empty_stage.empty() || empty_stage.pixels.size() == photograph.pixels.size()) &&
                       (shadow.empty() || shadow.size() == odds.size()),
                   "evidence of the picture's size");
  const Image picture = toned(photograph), stage = toned(empty_stage);
  const auto edge = [&](std::size_t p, std::size_t q) {
    if (stage.empty() || (!shadow.empty() && shadow[p] && shadow[q]))
      return squared(colour(picture, p), colour(picture, q));
    return squared_change(colour(picture, p), colour(stage, p), colour(picture, q), colour(stage, q));
  };
  double contrast = 0;
  long pairs = 0;
  each_pair(picture, [&](std::size_t p, std::size_t q, float) { contrast += edge(p, q), ++pairs; });
  const float beta = contrast > 0 ? static_cast<float>(static_cast<double>(pairs) / (2 * contrast)) : 0;
  GraphCut graph(static_cast<int>(odds.size()), static_cast<std::size_t>(pairs));
  each_pair(picture, [&](std::size_t p, std::size_t q, float length) {
    const float alike = std::exp(-beta * edge(p, q));
    const int weight = whole(static_cast<float>(smooth) * std::max(alike, kFloor) / length);
    graph.add_edge(static_cast<int>(p), static_cast<int>(q), weight, weight);
  });
  for (std::size_t p = 0; p < odds.size(); ++p) {
    float o = std::clamp(odds[p], -kCertain, kCertain);
    if (!certain.empty() && certain[p] != Certain::No)
      o = certain[p] == Certain::Subject ? kCertain : -kCertain;
    graph.add_terminals(static_cast<int>(p), whole(std::max(0.0f, o)), whole(std::max(0.0f, -o)));
  }
  graph.solve();
  Image out(picture.width, picture.height, 1);
  for (std::size_t p = 0; p < odds.size(); ++p)
    if (graph.on_source_side(static_cast<int>(p))) out.pixels[p] = 255;
  return out;
}

}  // namespace floatstage::matting
