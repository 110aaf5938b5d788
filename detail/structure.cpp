// Structural adaptation: M. Eisemann, section 4.3.2.2 to 4.3.2.4, with J. Canny's edges (PAMI 1986) after a
// bilateral filter (C. Tomasi, R. Manduchi 1998). Differs: edges on the seam are placed to a fraction of a
// pixel and matched only where they rise the same way, and some may stay without a partner (ADR 0219).

#include "detail/structure.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "core/statistics.h"
#include "detail/harmonic_fill.h"

namespace floatstage::detail {
namespace {

using Eigen::Vector2d;

constexpr int kShortestSeam = 24;
constexpr double kZeroAfter = 0.1;  // of the seam's length

Field luminance(const LightPicture& p) {
  Field out(p.width, p.height);
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const Light& l = p.pixels[i];
    out.values[i] = encoded(std::clamp(0.2126F * l[0] + 0.7152F * l[1] + 0.0722F * l[2], 0.0F, 1.0F));
  }
  return out;
}

cv::Mat matrix_of(const Field& f) { return {f.height, f.width, CV_32F, const_cast<float*>(f.values.data())}; }

// Thin edges. The strong ones are the tenth of all pixels with the largest gradients.
std::vector<std::uint8_t> canny_edges(const Field& f) {
  cv::Mat smooth, bytes, dx, dy, edges;
  cv::bilateralFilter(matrix_of(f), smooth, 7, 0.1, 2, cv::BORDER_REPLICATE);
  smooth.convertTo(bytes, CV_8U, 255);
  cv::Sobel(bytes, dx, CV_16S, 1, 0);
  cv::Sobel(bytes, dy, CV_16S, 0, 1);
  std::vector<float> sizes;
  for (int y = 0; y < dx.rows; ++y)
    for (int x = 0; x < dx.cols; ++x)
      sizes.push_back(static_cast<float>(std::hypot(dx.at<short>(y, x), dy.at<short>(y, x))));
  const double strong = std::max(40.0, static_cast<double>(percentile(std::move(sizes), 0.9)));
  cv::Canny(dx, dy, edges, 0.4 * strong, strong, true);
  std::vector<std::uint8_t> out;
  for (int y = 0; y < edges.rows; ++y)
    for (int x = 0; x < edges.cols; ++x) out.push_back(edges.at<std::uint8_t>(y, x) != 0 ? 1 : 0);
  return out;
}

float sample(const Field& f, const Vector2d& p) {
  const double x = std::clamp(p.x() - 0.5, 0.0, f.width - 1.001),
               y = std::clamp(p.y() - 0.5, 0.0, f.height - 1.001);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const auto a = static_cast<float>(x - i), b = static_cast<float>(y - j);
  return (1 - b) * ((1 - a) * f.at(i, j) + a * f.at(i + 1, j)) +
         b * ((1 - a) * f.at(i, j + 1) + a * f.at(i + 1, j + 1));
}

/// A closed seam in steps of a pixel, smoothed a little: a staircase would be full of edges.
struct Way {
  std::vector<Vector2d> points;
  int size() const { return static_cast<int>(points.size()); }
  const Vector2d& at(int i) const {
    return points[static_cast<std::size_t>(((i % size()) + size()) % size())];
  }
  Vector2d at(double t) const {
    const int i = static_cast<int>(std::floor(t));
    return at(i) + (t - i) * (at(i + 1) - at(i));
  }
};

std::vector<Way> ways_along(const std::vector<std::uint8_t>& seam, int width, int height) {
  const cv::Mat mask(height, width, CV_8U, const_cast<std::uint8_t*>(seam.data()));
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask.clone(), contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::vector<Way> ways;
  for (const std::vector<cv::Point>& contour : contours) {
    const int n = static_cast<int>(contour.size());
    if (n < kShortestSeam) continue;
    Way way;
    constexpr int kSmooth = 4;
    for (int i = 0; i < n; ++i) {
      Vector2d sum(0, 0);
      for (int k = -kSmooth; k <= kSmooth; ++k) {
        const cv::Point& p = contour[static_cast<std::size_t>((i + k + n) % n)];
        sum += Vector2d(p.x + 0.5, p.y + 0.5);
      }
      way.points.push_back(sum / (2 * kSmooth + 1));
    }
    ways.push_back(std::move(way));
  }
  return ways;
}

/// An edge that crosses a way: where, and how steeply the brightness rises along it.
struct Crossing {
  double at;
  float rise;
};

// Extrema of the brightness' slope along the way that lie on an edge of the picture.
std::vector<Crossing> crossings(const Way& way, const Field& f, const std::vector<std::uint8_t>& edges) {
  const int n = way.size();
  std::vector<float> value, slope;
  for (int i = 0; i < n; ++i) value.push_back(sample(f, way.at(i)));
  const auto v = [&](int i) { return value[static_cast<std::size_t>(((i % n) + n) % n)]; };
  for (int i = 0; i < n; ++i)
    slope.push_back((2 * (v(i + 2) - v(i - 2)) + (v(i + 1) - v(i - 1)) + 2 * (v(i + 3) - v(i - 3))) / 22);
  const auto s = [&](int i) { return slope[static_cast<std::size_t>(((i % n) + n) % n)]; };
  const auto on_edge = [&](const Vector2d& p) {
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const int x = static_cast<int>(p.x()) + dx, y = static_cast<int>(p.y()) + dy;
        if (x >= 0 && y >= 0 && x < f.width && y < f.height && edges[f.index(x, y)] != 0) return true;
      }
    return false;
  };
  std::vector<Crossing> found;
  for (int i = 0; i < n; ++i) {
    const float here = std::abs(s(i)), before = std::abs(s(i - 1)), after = std::abs(s(i + 1));
    if (here < 0.004F || here < before || here <= after || !on_edge(way.at(i))) continue;
    const double bend = before - 2 * here + after;
    const double shift = bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
    found.push_back({i + shift, s(i)});
  }
  return found;
}

// The cheapest matching that keeps the order (Eq. 4.3); leaving one without a partner costs as much as
// matching it at the reach's end with another's steepness.
std::vector<std::pair<int, int>> matched(const std::vector<Crossing>& parent,
                                         const std::vector<Crossing>& child, double reach) {
  const std::size_t m = parent.size(), n = child.size();
  const double alone = reach * reach / 2;
  std::vector<double> cost((m + 1) * (n + 1), 0);
  std::vector<std::uint8_t> step(cost.size(), 0);  // 1: both, 2: the parent's alone, 3: the child's alone
  const auto at = [&](std::size_t i, std::size_t j) { return i * (n + 1) + j; };
  for (std::size_t i = 0; i <= m; ++i)
    for (std::size_t j = 0; j <= n; ++j) {
      if (i == 0 && j == 0) continue;
      double best = 1e300;
      std::uint8_t how = 0;
      const auto offer = [&](double c, std::uint8_t h) {
        if (c < best) best = c, how = h;
      };
      if (i > 0) offer(cost[at(i - 1, j)] + alone, 2);
      if (j > 0) offer(cost[at(i, j - 1)] + alone, 3);
      if (i > 0 && j > 0) {
        const Crossing &p = parent[i - 1], &c = child[j - 1];
        const double apart = p.at - c.at, ratio = std::log(std::abs(p.rise) / std::abs(c.rise));
        if (std::abs(apart) <= reach && p.rise * c.rise > 0)
          offer(cost[at(i - 1, j - 1)] + apart * apart + alone * ratio * ratio, 1);
      }
      cost[at(i, j)] = best;
      step[at(i, j)] = how;
    }
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = m, j = n; i > 0 || j > 0;) {
    const std::uint8_t how = step[at(i, j)];
    if (how == 1) pairs.emplace_back(static_cast<int>(i) - 1, static_cast<int>(j) - 1);
    if (how != 3) --i;
    if (how != 2) --j;
  }
  std::reverse(pairs.begin(), pairs.end());
  return pairs;
}

// The pixels of an edge from where it crosses the seam, into the child.
std::vector<Vector2d> traced(const std::vector<std::uint8_t>& edges, const std::vector<std::uint8_t>& seam,
                             int width, int height, const Vector2d& from, int length) {
  const auto is_edge = [&](int x, int y) {
    const std::size_t i =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    return x >= 0 && y >= 0 && x < width && y < height && edges[i] != 0 && seam[i] != 0;
  };
  int x = 0, y = 0;
  double nearest = 9;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const int u = static_cast<int>(from.x()) + dx, v = static_cast<int>(from.y()) + dy;
      const double d = (Vector2d(u + 0.5, v + 0.5) - from).squaredNorm();
      if (is_edge(u, v) && d < nearest) nearest = d, x = u, y = v;
    }
  std::vector<Vector2d> way;
  if (nearest >= 9) return way;
  way.emplace_back(x + 0.5, y + 0.5);
  while (static_cast<int>(way.size()) < length) {
    // The neighbour farthest from where it began: an edge does not turn back within so few pixels.
    std::optional<Vector2d> next;
    double farthest = (way.back() - from).squaredNorm();
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const Vector2d p(x + dx + 0.5, y + dy + 0.5);
        if (!is_edge(x + dx, y + dy) || (p - from).squaredNorm() <= farthest) continue;
        farthest = (p - from).squaredNorm();
        next = p;
      }
    if (!next) break;
    way.push_back(*next);
    x = static_cast<int>(next->x());
    y = static_cast<int>(next->y());
  }
  return way;
}

/// What the diffusion starts from.
struct Constraints {
  LightPicture values;
  std::vector<std::uint8_t> fixed;
  void put(const Vector2d& at, const Vector2d& d) {
    const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
    if (x < 0 || y < 0 || x >= values.width || y >= values.height) return;
    fixed[values.index(x, y)] = 1;
    values.at(x, y) = {static_cast<float>(d.x()), static_cast<float>(d.y()), 0, 0};
  }
};

// Displacements on a whole way, from those of the matched edges: linear between them, zero far from all.
void put_on_way(const Way& way, const std::vector<std::pair<double, Vector2d>>& known, Constraints& to) {
  const double n = way.size(), far = kZeroAfter * n;
  std::vector<std::pair<double, Vector2d>> knots;
  for (std::size_t i = 0; i < known.size(); ++i) {
    knots.push_back(known[i]);
    const double next = i + 1 < known.size() ? known[i + 1].first : known[0].first + n;
    if (next - known[i].first <= 2 * far) continue;
    knots.emplace_back(known[i].first + far, Vector2d::Zero());
    knots.emplace_back(next - far, Vector2d::Zero());
  }
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const double begin = knots[i].first, end = i + 1 < knots.size() ? knots[i + 1].first : knots[0].first + n;
    const Vector2d &a = knots[i].second, &b = knots[(i + 1) % knots.size()].second;
    for (int t = static_cast<int>(std::ceil(begin)); t < end; ++t)
      to.put(way.at(t), a + (b - a) * (end > begin ? (t - begin) / (end - begin) : 0));
  }
}

void trace_inwards(const Structure& s, const std::vector<std::uint8_t>& seam, const EdgePair& edge, int trace,
                   Structure& out, Constraints& to) {
  const int w = to.values.width, h = to.values.height;
  const std::vector<Vector2d> of_parent = traced(s.edges_parent, seam, w, h, edge.parent, trace),
                              of_child = traced(s.edges_child, seam, w, h, edge.child, trace);
  const std::size_t n = std::min(of_parent.size(), of_child.size());
  const Vector2d first = edge.child - edge.parent;
  for (std::size_t i = 1; i < n; ++i) {
    // Pixels are whole numbers: the mean over five steps is finer, and begins with what the seam knows.
    Vector2d sum = first;
    int count = 1;
    for (std::size_t k = i >= 2 ? i - 2 : 1; k < std::min(n, i + 3); ++k, ++count)
      sum += of_child[k] - of_parent[k];
    const Vector2d d = sum / count;
    if ((d - first).norm() > 3) break;  // the two ways are not of one edge any more
    to.put(of_parent[i], d);
    out.along_edges.push_back({of_parent[i], of_parent[i] + d});
  }
}

}  // namespace

Structure align_structure(const LightPicture& child, const LightPicture& parent,
                          const std::vector<std::uint8_t>& seam, double reach, int trace) {
  FLOATSTAGE_CHECK(child.pixels.size() == parent.pixels.size() && seam.size() == child.pixels.size(),
                   "one size");
  Structure s;
  const Field of_child = luminance(child), of_parent = luminance(parent);
  s.edges_child = canny_edges(of_child);
  s.edges_parent = canny_edges(of_parent);
  Constraints constraints{LightPicture(child.width, child.height), std::vector<std::uint8_t>(seam.size(), 0)};
  for (const Way& way : ways_along(seam, child.width, child.height)) {
    const std::vector<Crossing> in_parent = crossings(way, of_parent, s.edges_parent),
                                in_child = crossings(way, of_child, s.edges_child);
    std::vector<std::pair<double, Vector2d>> known;
    for (const auto& [p, c] : matched(in_parent, in_child, reach)) {
      const double at = in_parent[static_cast<std::size_t>(p)].at;
      const EdgePair edge{way.at(at), way.at(in_child[static_cast<std::size_t>(c)].at)};
      known.emplace_back(at, edge.child - edge.parent);
      s.on_seam.push_back(edge);
    }
    put_on_way(way, known, constraints);
  }
  for (const EdgePair& edge : s.on_seam) trace_inwards(s, seam, edge, trace, s, constraints);
  fill_harmonically(constraints.values, constraints.fixed, 1e-3F);
  s.displacement = std::move(constraints.values);
  return s;
}

LightPicture displaced(const LightPicture& child, const LightPicture& displacement) {
  LightPicture out(child.width, child.height);
  for (int y = 0; y < child.height; ++y)
    for (int x = 0; x < child.width; ++x) {
      const Light& d = displacement.at(x, y);
      const double u = x + 0.5 + static_cast<double>(d[0]), v = y + 0.5 + static_cast<double>(d[1]);
      out.at(x, y) = d[0] == 0 && d[1] == 0 ? child.at(x, y) : interpolated(child, u, v);
    }
  return out;
}

}  // namespace floatstage::detail
