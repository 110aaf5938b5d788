#include "matting/view_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "core/check.h"
#include "core/graph_cut.h"
#include "matting/keyers/plate.h"
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
constexpr double kStillNoise = 2;        // 8-bit steps a channel: a place is no quieter than that
constexpr double kSomethingElse = 0.05;  // density of what stands before a place, against a colour's spread
constexpr double kSpread = 25;           // 8-bit steps, of colours at large
constexpr float kNeverChanged = 1.5f, kMostStill = 3;  // log-odds
constexpr int kChange = 20;                            // 8-bit steps a channel that are no noise

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

bool is_light(std::uint8_t plate_class) {
  return plate_class == static_cast<std::uint8_t>(PlateClass::Shadow) ||
         plate_class == static_cast<std::uint8_t>(PlateClass::Reflex);
}

// A pixel that shows a little of the subject is unlike the empty stage, too: at the rim only colours tell.
std::vector<float> without_rim(const std::vector<float>& odds, int w, int h) {
  std::vector<float> inner = odds;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float& here = inner[static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x)];
      if (here <= 0) continue;
      for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
        const int u = std::clamp(x + dx, 0, w - 1), v = std::clamp(y + dy, 0, h - 1);
        here = std::min(here,
                        std::max(0.0f, odds[static_cast<std::size_t>(v) * w + static_cast<std::size_t>(u)]));
      }
    }
  return inner;
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

Result<StillBackdrop> StillBackdrop::learn(std::span<const Image> pictures, std::span<const Image> subjects) {
  if (pictures.size() < 2)
    return fail(ErrorCode::InvalidArgument, "a backdrop is learnt from two pictures or more");
  Result<Plate> plate =
      learn_plate({pictures.begin(), pictures.end()}, {}, {subjects.begin(), subjects.end()});
  if (!plate) return forward(plate);
  StillBackdrop out;
  out.changed_.assign(pixels(plate->color), 0);
  out.seen_.assign(out.changed_.size(), subjects.empty());
  for (const Image& subject : subjects)
    for (std::size_t p = 0; p < out.seen_.size(); ++p) out.seen_[p] |= subject.pixels[p] == 0;
  for (const Image& picture : pictures)
    for (std::size_t p = 0; p < out.changed_.size(); ++p)
      for (int c = 0; c < 3; ++c)
        if (std::abs(colour(picture, p)[c] - colour(plate->color, p)[c]) > kChange) out.changed_[p] = 1;
  out.plate_ = std::move(*plate);
  return out;
}

Result<StillBackdrop> StillBackdrop::of_empty_stage(const std::vector<Image>& photographs) {
  Result<Plate> plate = learn_plate(photographs);
  if (!plate) return forward(plate);
  StillBackdrop out;
  out.seen_.assign(pixels(plate->color), 1);
  out.changed_ = out.seen_;
  out.plate_ = std::move(*plate);
  out.empty_stage_ = true;
  return out;
}

std::vector<float> StillBackdrop::odds(const Image& picture, const Image& unlike) const {
  FLOATSTAGE_CHECK(picture.width == plate_.color.width && picture.height == plate_.color.height,
                   "a picture of its size");
  FLOATSTAGE_CHECK(unlike.empty() || unlike.pixels.size() == changed_.size(),
                   "what is unlike is of its size");
  std::vector<float> odds(changed_.size());
  const Image classes = empty_stage_ ? classify(plate_, picture) : Image();
  for (std::size_t p = 0; p < odds.size(); ++p) {
    if (!knows(p)) continue;
    const double sigma = std::max(kStillNoise, plate_.noise.pixels[p] / 16.0);
    const double z = squared(colour(picture, p), colour(plate_.color, p)) / (3 * sigma * sigma);
    const double here =
        plate_.confidence.pixels[p] / 255.0 * std::exp(-0.5 * z) * kSpread / sigma + kSomethingElse;
    const float most = changed_[p] ? kMostStill : kNeverChanged;
    odds[p] = std::clamp(static_cast<float>(-std::log(here)), -most, kMostStill);
    if (empty_stage_ && is_light(classes.pixels[p])) odds[p] = std::min(odds[p], 0.0f);
  }
  if (!empty_stage_) return odds;
  std::vector<float> inner = without_rim(odds, picture.width, picture.height);
  for (std::size_t p = 0; p < unlike.pixels.size(); ++p)
    if (unlike.pixels[p]) inner[p] = odds[p];
  return inner;
}

Image cut_view(const Image& photograph, std::span<const float> odds, std::span<const Certain> certain,
               double smooth, const Image& empty_stage) {
  FLOATSTAGE_CHECK(photograph.channels == 3 && odds.size() == pixels(photograph) &&
                       (certain.empty() || certain.size() == odds.size()) &&
                       (empty_stage.empty() || empty_stage.pixels.size() == photograph.pixels.size()),
                   "evidence of the picture's size");
  const Image picture = toned(photograph), stage = toned(empty_stage);
  const auto edge = [&](std::size_t p, std::size_t q) {
    if (stage.empty()) return squared(colour(picture, p), colour(picture, q));
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
