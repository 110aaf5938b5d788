#include "recon/mesh/mesh_silhouettes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "recon/mesh/mesh_mask.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector2d;

constexpr double kFarthest = 1e6;  // px: beyond, rows are cut where doubles have few digits left

}  // namespace

/// Winding numbers of outlines around the middles of pixels, as differences along each row that is looked at.
class MeshSilhouettes::Windings {
 public:
  /// Rows `first`, `first` + `step` and so on.
  Windings(int width, int height, int first, int step)
      : width_(width),
        first_(first),
        step_(step),
        rows_(std::max(0, (height - first + step - 1) / step)),
        begin_(rows_),
        steps_(stride() * static_cast<std::size_t>(rows_)) {}

  /// An edge of an outline.
  void add(const Vector2d& from, const Vector2d& to) {
    const bool down = from.y() < to.y();
    const Vector2d &low = down ? from : to, &high = down ? to : from;
    // Of a vertex on a row's middle, the edge below it has the row: once, whatever meets there.
    const auto row_from = [&](double y) {
      return static_cast<int>(
          std::ceil(std::clamp((y - 0.5 - first_) / step_, 0.0, static_cast<double>(rows_))));
    };
    const int begin = row_from(low.y()), end = row_from(high.y());
    if (begin >= end) return;
    begin_ = std::min(begin_, begin), end_ = std::max(end_, end);
    const double slope = (high.x() - low.x()) / (high.y() - low.y());
    for (int r = begin; r < end; ++r) {
      const double x = low.x() + (first_ + r * step_ + 0.5 - low.y()) * slope;
      const double column = std::ceil(std::clamp(x - 0.5, 0.0, static_cast<double>(width_)));
      steps_[static_cast<std::size_t>(r) * stride() + static_cast<std::size_t>(column)] += down ? 1 : -1;
    }
  }

  /// Visits rows with 0 and 255, which may be changed: those that no outline comes to are all 0.
  template <class Visit>
  void rows(const Visit& visit) const {
    std::vector<std::uint8_t> row(static_cast<std::size_t>(width_));
    for (int r = 0; r < rows_; ++r) {
      const std::int32_t* step = steps_.data() + static_cast<std::size_t>(r) * stride();
      std::int32_t winding = 0;
      if (r < begin_ || r >= end_) {
        std::fill(row.begin(), row.end(), std::uint8_t{0});
      } else {
        for (std::size_t x = 0; x < row.size(); ++x) {
          winding += step[x];
          row[x] = winding != 0 ? 255 : 0;
        }
      }
      visit(first_ + r * step_, row.data());
    }
  }

 private:
  std::size_t stride() const { return static_cast<std::size_t>(width_) + 1; }
  int width_, first_, step_, rows_;
  int begin_, end_ = 0;  // rows that outlines come to
  std::vector<std::int32_t> steps_;
};

MeshSilhouettes::MeshSilhouettes(Mesh mesh) : mesh_(std::move(mesh)) {
  // Half-edges by their lower vertex.
  struct Half {
    std::uint32_t upper, triangle;
    bool up;
  };
  const std::vector<std::uint32_t>& corners = mesh_.triangles;
  const std::size_t triangles = corners.size() / 3;
  const auto each = [&](const auto& visit) {
    for (std::size_t t = 0; t < triangles; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        visit(static_cast<std::uint32_t>(t), corners[3 * t + k], corners[3 * t + (k + 1) % 3]);
  };
  std::vector<std::uint32_t> end(mesh_.positions.size() + 1, 0);
  each([&](std::uint32_t, std::uint32_t a, std::uint32_t b) { ++end[std::min(a, b)]; });
  std::uint32_t sum = 0;
  for (std::uint32_t& e : end) std::swap(e, sum), sum += e;  // where each begins; when filled, where it ends
  std::vector<Half> halves(3 * triangles);
  each([&](std::uint32_t t, std::uint32_t a, std::uint32_t b) {
    halves[end[std::min(a, b)]++] = {std::max(a, b), t, a < b};
  });
  edges_.reserve(halves.size() / 2);
  for (std::size_t v = 0, first = 0; v < mesh_.positions.size(); first = end[v++]) {
    const auto begin = halves.begin() + static_cast<std::ptrdiff_t>(first),
               last = halves.begin() + static_cast<std::ptrdiff_t>(end[v]);
    std::sort(begin, last, [](const Half& p, const Half& q) {
      return std::tie(p.upper, p.up, p.triangle) < std::tie(q.upper, q.up, q.triangle);
    });
    for (auto group = begin; group != last;) {
      const auto next = std::find_if(group, last, [&](const Half& h) { return h.upper != group->upper; });
      const auto up = std::find_if(group, next, [](const Half& h) { return h.up; });
      if (up - group != next - up) return;  // open, or turned inside out somewhere
      for (auto down = group, other = up; down != up; ++down, ++other)
        edges_.push_back({static_cast<std::uint32_t>(v), group->upper, other->triangle, down->triangle});
      group = next;
    }
  }
  closed_ = true;
}

// False where mesh_mask() has to.
bool MeshSilhouettes::draw(const RigCamera& camera, Windings& windings) const {
  if (!closed_) return false;
  const Eigen::Matrix3d rotation = camera.cam_from_world.rotation.toRotationMatrix();
  std::vector<Vector2d> pixels(mesh_.positions.size());
  for (std::size_t v = 0; v < pixels.size(); ++v) {
    const std::optional<Vector2d> pixel = project(
        camera.model, rotation * mesh_.positions[v].cast<double>() + camera.cam_from_world.translation);
    if (!pixel || !(pixel->cwiseAbs().maxCoeff() < kFarthest)) return false;
    pixels[v] = *pixel;
  }
  std::vector<std::uint8_t> front(mesh_.triangle_count());
  for (std::size_t t = 0; t < front.size(); ++t) {
    const Vector2d &a = pixels[mesh_.triangles[3 * t]], &b = pixels[mesh_.triangles[3 * t + 1]],
                   &c = pixels[mesh_.triangles[3 * t + 2]];
    front[t] = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()) < 0;
  }
  for (const Edge& edge : edges_) {
    const bool along = front[edge.along_triangle] != 0;
    if (along == (front[edge.back_triangle] != 0)) continue;
    const Vector2d &from = pixels[edge.from], &to = pixels[edge.to];
    along ? windings.add(from, to) : windings.add(to, from);
  }
  return true;
}

Matte MeshSilhouettes::of(const RigCamera& camera) const {
  const CameraModel& m = camera.model;
  Windings windings(m.width, m.height, 0, 1);
  if (!draw(camera, windings)) return mesh_mask(camera, mesh_);
  Image mask(m.width, m.height, 1);
  windings.rows([&](int y, const std::uint8_t* row) { std::copy_n(row, m.width, mask.at(0, y)); });
  return make_matte({}, mask);
}

double MeshSilhouettes::iou(const RigCamera& camera, const Matte& matte, int step) const {
  const int first = step / 2;
  std::int64_t both = 0, either = 0;
  const auto count = [&](int y, const std::uint8_t* row) {
    const std::uint8_t* const other = matte.row(y);
    int both_here = 0, either_here = 0;
    for (int x = 0; x < matte.width; ++x) {
      both_here += (row[x] & other[x]) >> 7;
      either_here += (row[x] | other[x]) >> 7;
    }
    both += both_here, either += either_here;
  };
  Windings windings(matte.width, matte.height, first, step);
  if (draw(camera, windings)) {
    windings.rows(count);
  } else {
    const Matte mask = mesh_mask(camera, mesh_);
    for (int y = first; y < matte.height; y += step) count(y, mask.row(y));
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 1;
}

}  // namespace floatstage::recon
