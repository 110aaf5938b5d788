// Method:  polygons filled by scan lines, several a pixel, and filtered; each line is integrated exactly
// Paper:   area with a filter of choice: E. Catmull, "A hidden-surface algorithm with anti-aliasing", 1978
// Differs: the filter is the shadow of a sphere's shell, 1/(2 pi sqrt(1 - r²)): by Archimedes' theorem of the
//          sphere and the cylinder an edge at any angle crosses it evenly, so that opacity is linear in the
//          distance to the edge over two pixels, and linear interpolation (trace_outline()) finds it again
// ADR:     0242
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/import/contours.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector2d;

constexpr int kLines = 32;    // scan lines a pixel: edges along rows are known to half of one
constexpr double kCut = 1;    // px: what comes this near to the border goes on beyond it
constexpr double kFar = 1e6;  // px

struct Interval {
  double begin, end;
};
using Line = std::vector<Interval>;

double line_y(int line) { return (line + 0.5) / kLines; }

/// Where the shape's edges cross each line, in pairs.
void add_intervals(const ContourShape& shape, std::vector<Line>& lines) {
  std::vector<std::pair<int, double>> crossings;
  for (const std::vector<Vector2d>& polygon : shape.polygons)
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const auto line_of = [&](double y) {
        return static_cast<int>(
            std::clamp(std::ceil(y * kLines - 0.5), 0.0, static_cast<double>(lines.size())));
      };
      const int end = line_of(std::max(a.y(), b.y()));
      for (int k = line_of(std::min(a.y(), b.y())); k < end; ++k)
        crossings.emplace_back(k, a.x() + (line_y(k) - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
  std::sort(crossings.begin(), crossings.end());
  for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
    lines[static_cast<std::size_t>(crossings[i].first)].push_back(
        {crossings[i].second, crossings[i + 1].second});
}

/// Intervals that touch become one; those that reach the border go on beyond it.
void unite(Line& line, int width) {
  std::sort(line.begin(), line.end(), [](const Interval& a, const Interval& b) { return a.begin < b.begin; });
  Line out;
  for (const Interval& next : line) {
    if (!out.empty() && next.begin <= out.back().end)
      out.back().end = std::max(out.back().end, next.end);
    else
      out.push_back(next);
  }
  std::erase_if(out, [&](const Interval& i) { return i.end <= kCut || i.begin >= width - kCut; });
  for (Interval& i : out) {
    if (i.begin <= kCut) i.begin = -kFar;
    if (i.end >= width - kCut) i.end = width + kFar;
  }
  line = std::move(out);
}

/// One row of pixels: what each line near it has inside.
class Row {
 public:
  explicit Row(int width)
      : part_(static_cast<std::size_t>(width)), step_(static_cast<std::size_t>(width) + 1) {}

  void clear() {
    std::fill(part_.begin(), part_.end(), 0.0);
    std::fill(step_.begin(), step_.end(), 0.0);
  }

  /// A line `off` px from the row's middle.
  void add(const Line& line, double off) {
    const double reach = std::sqrt(std::max(0.0, 1 - off * off));
    for (const Interval& i : line) {
      boundary(i.end, reach, 1);
      boundary(i.begin, reach, -1);
    }
  }

  void write(std::uint8_t* alpha) const {
    double constant = 0;
    for (std::size_t x = 0; x < part_.size(); ++x) {
      constant += step_[x];
      alpha[x] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(part_[x] + constant, 0.0, 1.0)));
    }
  }

 private:
  // The filter's share left of the boundary, less half: its integral along the line is half whatever the
  // line.
  void boundary(double at, double reach, double sign) {
    const double width = static_cast<double>(part_.size());
    const auto column = [&](double x) {
      return static_cast<std::size_t>(std::clamp(std::ceil(x - 0.5), 0.0, width));
    };
    const std::size_t first = column(at - reach), last = column(at + reach);
    const double share = sign / kLines;
    step_[0] += share / 4;
    step_[first] -= share / 4;
    for (std::size_t x = first; x < last; ++x) {
      const double t = std::clamp((at - (static_cast<double>(x) + 0.5)) / reach, -1.0, 1.0);
      part_[x] += share * std::asin(t) / (2 * std::numbers::pi);
    }
    step_[last] -= share / 4;
  }

  std::vector<double> part_, step_;  // step_: differences of what is constant from there on
};

}  // namespace

Image matte_of(const PictureContours& contours) {
  const int width = contours.width, height = contours.height, count = height * kLines;
  std::vector<Line> lines(static_cast<std::size_t>(count));
  for (const ContourShape& shape : contours.shapes) add_intervals(shape, lines);
  for (Line& line : lines) unite(line, width);
  const int margin = std::min(static_cast<int>(kCut * kLines), (count - 1) / 2);
  Image alpha(width, height, 1);
  Row row(width);
  for (int y = 0; y < height; ++y) {
    row.clear();
    const double middle = y + 0.5;
    for (int k = (y - 1) * kLines + kLines / 2; k < (y + 1) * kLines + kLines / 2; ++k)
      row.add(lines[static_cast<std::size_t>(std::clamp(k, margin, count - 1 - margin))], line_y(k) - middle);
    row.write(alpha.at(0, y));
  }
  return alpha;
}

std::optional<Vector2d> crossing_of(const std::vector<std::vector<Vector2d>>& polygons) {
  struct Edge {
    Vector2d a, b;
    double top, bottom, left, right;
  };
  std::vector<Edge> edges;
  for (const std::vector<Vector2d>& polygon : polygons)
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      edges.push_back({a, b, std::min(a.y(), b.y()), std::max(a.y(), b.y()), std::min(a.x(), b.x()),
                       std::max(a.x(), b.x())});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.top < b.top; });
  const auto side = [](const Edge& edge, const Vector2d& p) {
    const Vector2d along = edge.b - edge.a, to = p - edge.a;
    return along.x() * to.y() - along.y() * to.x();
  };
  std::vector<const Edge*> open;
  for (const Edge& edge : edges) {
    std::erase_if(open, [&](const Edge* other) { return other->bottom < edge.top; });
    for (const Edge* other : open) {
      if (other->right < edge.left || other->left > edge.right) continue;
      const double a = side(edge, other->a), b = side(edge, other->b);
      if (a * b < 0 && side(*other, edge.a) * side(*other, edge.b) < 0)
        return other->a + a / (a - b) * (other->b - other->a);
    }
    open.push_back(&edge);
  }
  return std::nullopt;
}

}  // namespace floatstage::pipeline
