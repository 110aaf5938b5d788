// The strength of details as a function of what the root shows: ridge regression (A. Hoerl and R. Kennard,
// 1970) of the logarithms of their mean squares on colours and on the strengths of the root's own three
// finest octaves in four directions, and on the products of two of these. Every example counts in four ways,
// mirrored and turned over the diagonal, since what lies beside a close photograph may lie in another
// direction.

#include "detail/synthesis/strengths.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace floatstage::detail {
namespace {

constexpr std::size_t kOctaves = 3, kDirections = 4, kColors = 3;
constexpr std::size_t kFeatures = kColors + kOctaves * kDirections;
constexpr int kTerms = 1 + static_cast<int>(kFeatures + kFeatures * (kFeatures + 1) / 2);
constexpr double kMostSamples = 65'536;  // of the root
constexpr std::size_t kFewest = 200;     // samples that close photographs have to show
// Chosen on panda (docs/constants.md).
constexpr double kRidge = 30;
constexpr float kShare = 0.7F;       // of the way, where the root shows what was learned from
constexpr float kStrangeness = 100;  // how fast that falls with the variance of what is predicted
constexpr float kMostLog = 1.386F;   // gains of 0.5 to 2

using Features = std::array<float, kFeatures>;
using Directions = std::array<float, kDirections>;
using Terms = Eigen::Matrix<double, kTerms, 1>;
using Logs = std::array<float, Strengths::kParts>;

// A mean that weighs pixels beside half as much, along x and y, `times` times.
template <std::size_t N>
void blur(Grid<std::array<float, N>>& grid, int times) {
  for (int t = 0; t < 2 * times; ++t) {
    const Grid<std::array<float, N>> from = grid;
    const int dx = t % 2, dy = 1 - dx;
    for (int y = grid.region.y0; y < grid.region.y1; ++y)
      for (int x = grid.region.x0; x < grid.region.x1; ++x)
        for (std::size_t c = 0; c < N; ++c)
          grid.at(x, y)[c] = 0.5F * from.at(x, y)[c] +
                             0.25F * (from.nearest(x - dx, y - dy)[c] + from.nearest(x + dx, y + dy)[c]);
  }
}

float grey(const Color& c) { return 0.299F * c[0] + 0.587F * c[1] + 0.114F * c[2]; }

// Between pixels, linearly, of a grid that is 1 / scale times as large.
template <std::size_t N>
std::array<float, N> between(const Grid<std::array<float, N>>& grid, float x, float y) {
  const float left = std::floor(x), top = std::floor(y), a = x - left, b = y - top;
  const auto at = [&](int dx, int dy) -> const std::array<float, N>& {
    return grid.nearest(static_cast<int>(left) + dx, static_cast<int>(top) + dy);
  };
  std::array<float, N> out;
  for (std::size_t k = 0; k < N; ++k)
    out[k] =
        (1 - b) * ((1 - a) * at(0, 0)[k] + a * at(1, 0)[k]) + b * ((1 - a) * at(0, 1)[k] + a * at(1, 1)[k]);
  return out;
}

// ln(mean square + 1) of second differences along x, y and the two diagonals.
Grid<Directions> directions_of(const ColorGrid& colors) {
  Grid<Directions> out(colors.region);
  for (int y = out.region.y0; y < out.region.y1; ++y)
    for (int x = out.region.x0; x < out.region.x1; ++x) {
      const auto at = [&](int dx, int dy) { return grey(colors.nearest(x + dx, y + dy)); };
      const auto along_x = [&](int dy) { return 2 * at(0, dy) - at(-1, dy) - at(1, dy); };
      const auto along_y = [&](int dx) { return 2 * at(dx, 0) - at(dx, -1) - at(dx, 1); };
      const Directions v = {(along_x(-1) + 2 * along_x(0) + along_x(1)) / 8,
                            (along_y(-1) + 2 * along_y(0) + along_y(1)) / 8,
                            at(0, 0) - (at(-1, -1) + at(1, 1)) / 2, at(0, 0) - (at(1, -1) + at(-1, 1)) / 2};
      for (std::size_t k = 0; k < kDirections; ++k) out.at(x, y)[k] = v[k] * v[k];
    }
  blur(out, 4);
  for (Directions& v : out.values)
    for (float& f : v) f = std::log(f + 1);
  return out;
}

// Of every step-th pixel of the root along x and y.
Grid<Features> features_of(const ColorGrid& root, int step) {
  Grid<Features> out(
      Region{0, 0, (root.region.width() + step - 1) / step, (root.region.height() + step - 1) / step});
  ColorGrid octave = root;
  blur(octave, 2);
  for (int y = 0; y < out.region.y1; ++y)
    for (int x = 0; x < out.region.x1; ++x)
      for (std::size_t c = 0; c < kColors; ++c) out.at(x, y)[c] = octave.at(x * step, y * step)[c] / 64;
  octave = root;
  float scale = 1;
  for (std::size_t o = 0; o < kOctaves; ++o, scale /= 2, octave = halved(octave)) {
    const Grid<Directions> found = directions_of(octave);
    for (int y = 0; y < out.region.y1; ++y)
      for (int x = 0; x < out.region.x1; ++x) {
        const auto on = [&](int at) { return (static_cast<float>(at * step) + 0.5F) * scale - 0.5F; };
        const Directions here = between(found, on(x), on(y));
        std::copy(here.begin(), here.end(),
                  out.at(x, y).begin() + static_cast<std::ptrdiff_t>(kColors + o * kDirections));
      }
  }
  return out;
}

// As a mirror (bit 0) and the diagonal (bit 1) turn them.
Features turned(const Features& f, int way) {
  Features out = f;
  for (std::size_t o = 0; o < kOctaves; ++o) {
    float* d = &out[kColors + o * kDirections];
    if ((way & 1) != 0) std::swap(d[2], d[3]);
    if ((way & 2) != 0) std::swap(d[0], d[1]);
  }
  return out;
}
Logs turned(const Logs& logs, int way) { return (way & 2) != 0 ? Logs{logs[1], logs[0], logs[2]} : logs; }

Terms terms_of(const Features& f) {
  Terms t;
  int k = 0;
  t[k++] = 1;
  for (const float v : f) t[k++] = static_cast<double>(v);
  for (std::size_t i = 0; i < kFeatures; ++i)
    for (std::size_t j = i; j < kFeatures; ++j) t[k++] = static_cast<double>(f[i] * f[j]) / 4;
  return t;
}

// ln(mean square + 1) of the parts of a level's details, in every pixel of level 0.
Grid<Logs> logs_of(const ColorGrid& detail, const Region& coarse, int level) {
  Grid<Logs> out(coarse, Logs{});
  const int cells = 1 << (level - 1);
  for (int v = 0; v < coarse.y1 * cells; ++v)
    for (int u = 0; u < coarse.x1 * cells; ++u) {
      const float a = grey(detail.at(2 * u, 2 * v)), b = grey(detail.at(2 * u + 1, 2 * v)),
                  c = grey(detail.at(2 * u, 2 * v + 1)), d = grey(detail.at(2 * u + 1, 2 * v + 1));
      const Logs parts = {(a - b + c - d) / 2, (a + b - c - d) / 2, (a - b - c + d) / 2};
      Logs& to = out.at(u / cells, v / cells);
      for (std::size_t k = 0; k < Strengths::kParts; ++k)
        to[k] += parts[k] * parts[k] / static_cast<float>(cells * cells);
    }
  blur(out, 1);
  for (Logs& l : out.values)
    for (float& f : l) f = std::log(f + 1);
  return out;
}

}  // namespace

/// One level's function.
class StrengthLearner {
 public:
  void add(const Features& features, const Logs& logs) {
    ++count_;
    for (std::size_t k = 0; k < Strengths::kParts; ++k) {
      least_[k] = std::min(least_[k], logs[k]);
      most_[k] = std::max(most_[k], logs[k]);
    }
    for (int way = 0; way < 4; ++way) {
      const Terms terms = terms_of(turned(features, way));
      const Logs target = turned(logs, way);
      squares_.selfadjointView<Eigen::Lower>().rankUpdate(terms);
      for (std::size_t k = 0; k < Strengths::kParts; ++k)
        products_.col(static_cast<Eigen::Index>(k)) += static_cast<double>(target[k]) * terms;
    }
  }
  std::size_t count() const { return count_; }

  Grid<Strengths::Expected> predict(const Grid<Features>& features) const {
    const Eigen::LLT<Eigen::MatrixXd> factor(squares_.selfadjointView<Eigen::Lower>());
    const Eigen::MatrixXd weights = factor.solve(products_);
    Grid<std::array<float, Strengths::kParts + 1>> found(features.region);
    for (std::size_t i = 0; i < found.values.size(); ++i) {
      const Terms terms = terms_of(features.values[i]);
      const Eigen::VectorXd v = weights.transpose() * terms;
      for (std::size_t k = 0; k < Strengths::kParts; ++k)
        found.values[i][k] =
            std::clamp(static_cast<float>(v[static_cast<Eigen::Index>(k)]), least_[k], most_[k]);
      const auto variance = static_cast<float>(factor.matrixL().solve(terms).squaredNorm());
      found.values[i].back() = kShare / (1 + kStrangeness * variance);
    }
    blur(found, 4);
    Grid<Strengths::Expected> out(features.region);
    for (std::size_t i = 0; i < found.values.size(); ++i) {
      std::copy_n(found.values[i].begin(), Strengths::kParts, out.values[i].logs.begin());
      out.values[i].share = found.values[i].back();
    }
    return out;
  }

 private:
  std::size_t count_ = 0;
  Logs least_{1e9F, 1e9F, 1e9F}, most_{};
  Eigen::MatrixXd squares_ = kRidge * Eigen::MatrixXd::Identity(kTerms, kTerms);
  Eigen::MatrixXd products_ = Eigen::MatrixXd::Zero(kTerms, Strengths::kParts);
};

Strengths::Strengths(const ColorGrid& root, const std::vector<LayerPyramid>& layers,
                     const Exemplars& exemplars, int levels)
    : levels_(static_cast<std::size_t>(levels) + 1) {
  while (static_cast<double>(root.region.width()) * root.region.height() > kMostSamples * step_ * step_)
    ++step_;
  const Grid<Features> features = features_of(root, step_);
  const Exemplars::Level& coarsest = exemplars.level(0);
  for (int t = 1; t <= levels; ++t) {
    Level& level = levels_[static_cast<std::size_t>(t)];
    const Exemplars::Level& from = exemplars.level(t);
    if (from.basis.dimensions() == 0) continue;
    level.exemplars_width = from.width;
    level.borrowed = logs_of(from.detail, {0, 0, coarsest.width, coarsest.height}, t);
    StrengthLearner learner;
    for (std::size_t i = 0; i < layers.size(); ++i)
      for (int y = 0; y < features.region.y1 && layers[i].finest() >= t; ++y)
        for (int x = 0; x < features.region.x1; ++x) {
          if (!layers[i].covers(0, x * step_, y * step_)) continue;
          const Exemplars::Place place = exemplars.place_of(i, 0, x * step_, y * step_);
          if (place != Exemplars::kNowhere) learner.add(features.at(x, y), level.borrowed.values[place]);
        }
    if (learner.count() >= kFewest) level.expected = learner.predict(features);
  }
}

Strengths::Gains Strengths::gains(int level, int x, int y, Exemplars::Place place) const {
  Gains out{1, 1, 1};
  const Level& l = levels_[static_cast<std::size_t>(level)];
  if (l.expected.values.empty() || place == Exemplars::kNowhere) return out;
  const auto width = static_cast<Exemplars::Place>(l.exemplars_width);
  const Expected& expected = l.expected.nearest((x >> (level - 1)) / step_, (y >> (level - 1)) / step_);
  const Logs& borrowed =
      l.borrowed.at(static_cast<int>(place % width) >> level, static_cast<int>(place / width) >> level);
  for (std::size_t k = 0; k < kParts; ++k)
    out[k] =
        std::exp(0.5F * std::clamp(expected.share * (expected.logs[k] - borrowed[k]), -kMostLog, kMostLog));
  return out;
}

}  // namespace floatstage::detail
