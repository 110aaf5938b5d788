#include "render/camera_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr double kSlack = 0.25;  // of the distance between neighbours: less is no other row

// Values that lie close together, in order: the mean of each heap, and each value's heap.
struct Heaps {
  std::vector<double> middle;
  std::vector<int> of;
};

Heaps heaps_of(const std::vector<double>& values, double apart) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  Heaps heaps{{}, std::vector<int>(values.size())};
  std::size_t first = 0;
  double sum = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    sum += values[order[i]];
    heaps.of[order[i]] = static_cast<int>(heaps.middle.size());
    if (i + 1 < order.size() && values[order[i + 1]] - values[order[i]] <= apart) continue;
    heaps.middle.push_back(sum / static_cast<double>(i + 1 - first));
    first = i + 1;
    sum = 0;
  }
  return heaps;
}

// The middle one of the cameras' distances to their nearest neighbours.
double spacing(const std::vector<Eigen::Vector3d>& centers) {
  std::vector<double> nearest;
  for (const Eigen::Vector3d& a : centers) {
    double best = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& b : centers)
      if (&a != &b) best = std::min(best, (a - b).norm());
    nearest.push_back(best);
  }
  std::nth_element(nearest.begin(), nearest.begin() + static_cast<long>(nearest.size() / 2), nearest.end());
  return nearest[nearest.size() / 2];
}

Result<CameraGrid> no_grid(const std::string& why) {
  return fail(ErrorCode::InvalidArgument,
              text("the cameras stand on no grid, which a light field needs: ", why));
}

}  // namespace

Result<CameraGrid> camera_grid(const std::vector<RigCamera>& cameras) {
  if (cameras.size() < 4) return no_grid(text("there are only ", cameras.size(), " of them, not four"));
  std::vector<Eigen::Vector3d> centers;
  Eigen::Vector3d right = Eigen::Vector3d::Zero(), down = right, middle = right;
  for (const RigCamera& c : cameras) {
    const Eigen::Matrix3d axes = c.cam_from_world.rotation.toRotationMatrix();
    right += axes.row(0).transpose();
    down += axes.row(1).transpose();
    centers.push_back(c.cam_from_world.center());
    middle += centers.back() / static_cast<double>(cameras.size());
  }
  if (right.norm() < 0.5 * static_cast<double>(cameras.size()) ||
      right.normalized().cross(down).norm() < 0.5 * static_cast<double>(cameras.size()))
    return no_grid("they look in all directions");
  CameraGrid grid;
  grid.origin = middle;
  grid.right = right.normalized();
  grid.down = (down - grid.right * grid.right.dot(down)).normalized();
  const double apart = kSlack * spacing(centers);
  if (!(apart > 0)) return no_grid("several stand in one place");
  std::vector<double> x, y;
  double off = 0;
  for (const Eigen::Vector3d& c : centers) {
    x.push_back(grid.right.dot(c - middle));
    y.push_back(grid.down.dot(c - middle));
    off = std::max(off, std::abs(grid.normal().dot(c - middle)));
  }
  if (off > apart) return no_grid(text("one stands ", off, " m before or behind the plane of the others"));
  const Heaps columns = heaps_of(x, apart), rows = heaps_of(y, apart);
  grid.x = columns.middle;
  grid.y = rows.middle;
  grid.columns = static_cast<int>(columns.middle.size());
  grid.rows = static_cast<int>(rows.middle.size());
  if (grid.rows < 2 || grid.columns < 2)
    return no_grid(text(grid.rows, " rows and ", grid.columns, " columns; two of each are the least"));
  const auto places = static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns);
  grid.cameras.assign(places, -1);
  std::size_t taken = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    int& place = grid.cameras[static_cast<std::size_t>(rows.of[i] * grid.columns + columns.of[i])];
    if (place < 0) ++taken;
    place = static_cast<int>(i);
  }
  if (taken < places)
    return no_grid(text("of ", grid.rows, " rows by ", grid.columns, " columns, ", places - taken,
                        " places have no camera"));
  if (cameras.size() > places) return no_grid("several stand in one place");
  return grid;
}

}  // namespace floatstage::render
