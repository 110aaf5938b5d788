#include <algorithm>
#include <cmath>

#include "recon/outline.h"

namespace floatstage::recon {

Matte filled(const Silhouette& outline, int width, int height) {
  if (outline.empty() && !outline.beyond_counts) return {};
  // Edges that go up enter the subject as one walks to the right, those that go down leave it. The steps lie
  // at the first pixel whose centre is right of the edge; half-open rows see each corner once.
  const std::size_t columns = static_cast<std::size_t>(width) + 1;
  std::vector<int> steps(columns * static_cast<std::size_t>(height), 0);
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &a = outline.points[i], &b = outline.points[i + 1 < end ? i + 1 : begin];
      const auto row_of = [&](double y) {
        return static_cast<int>(std::ceil(std::clamp(y - 0.5, -1.0, height * 1.0)));
      };
      const int first = std::max(0, row_of(std::min(a.y(), b.y())));
      const int last = std::min(height, row_of(std::max(a.y(), b.y())));
      for (int y = first; y < last; ++y) {
        const double x = a.x() + (y + 0.5 - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        const double column = std::ceil(std::clamp(x - 0.5, 0.0, width * 1.0));
        steps[columns * static_cast<std::size_t>(y) + static_cast<std::size_t>(column)] +=
            b.y() < a.y() ? 1 : -1;
      }
    }
  }
  Image alpha(width, height, 1);
  for (int y = 0; y < height; ++y) {
    int inside = outline.beyond_counts ? 1 : 0;
    for (int x = 0; x < width; ++x) {
      inside += steps[columns * static_cast<std::size_t>(y) + static_cast<std::size_t>(x)];
      *alpha.at(x, y) = inside > 0 ? 255 : 0;
    }
  }
  return make_matte({}, alpha);
}

}  // namespace floatstage::recon
