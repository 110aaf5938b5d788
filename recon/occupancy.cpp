#include "recon/occupancy.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/parallel.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

// What a camera's word on a pixel is worth to a voxel behind it.
float worth(float odds, const OccupancyOptions& o) {
  const double r = std::exp(std::clamp(static_cast<double>(odds), -20.0, 20.0));
  return static_cast<float>(
      std::log(((1 - o.mistaken) * r + o.mistaken) / (o.seen_anyway * r + 1 - o.seen_anyway)));
}

// A grey-scale closing by a square of 2 r + 1: voxels do not hit every pixel.
std::vector<float> closed(const std::vector<float>& picture, int w, int h, int r) {
  std::vector<float> from = picture, to(picture.size());
  const auto pass = [&](int dx, int dy, bool most) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        float v = from[static_cast<std::size_t>(y) * w + x];
        for (int s = -r; s <= r; ++s) {
          const int qx = x + s * dx, qy = y + s * dy;
          if (qx < 0 || qy < 0 || qx >= w || qy >= h) continue;
          const float other = from[static_cast<std::size_t>(qy) * w + qx];
          v = most ? std::max(v, other) : std::min(v, other);
        }
        to[static_cast<std::size_t>(y) * w + x] = v;
      }
    from.swap(to);
  };
  pass(1, 0, true);
  pass(0, 1, true);
  pass(1, 0, false);
  pass(0, 1, false);
  return from;
}

}  // namespace

OccupancyGrid::OccupancyGrid(const Rig& rig, const Eigen::AlignedBox3d& box, int voxels,
                             std::span<const Eigen::Vector2i> sizes, int seen_by, int threads)
    : box_(box), threads_(threads), sizes_(sizes.begin(), sizes.end()) {
  FLOATSTAGE_CHECK(sizes.size() == rig.cameras.size() && voxels > 0 && !box.isEmpty(), "an occupancy grid");
  const Vector3d extent = box.sizes().cwiseMax(1e-9);
  voxel_ = std::cbrt(extent.prod() / voxels);
  points_ = (extent / voxel_).array().ceil().cast<int>().max(1);
  const auto slice = static_cast<std::size_t>(points_.x()) * static_cast<std::size_t>(points_.y()),
             total = slice * static_cast<std::size_t>(points_.z());
  pixel_.resize(rig.cameras.size());
  for (std::size_t i = 0; i < pixel_.size(); ++i)
    if (sizes_[i].x() > 0) pixel_[i].assign(total, kUnseen);
  counts_.assign(total, 0);
  for (std::size_t i = 0; i < pixel_.size(); ++i) {
    const RigCamera& c = rig.cameras[i];
    const double depth = std::max((c.cam_from_world * box.center()).z(), 1e-6 * voxel_);
    const double footprint = voxel_ / depth * c.model.fx * sizes_[i].x() / c.model.width;
    reach_.push_back(std::clamp(static_cast<int>(std::ceil(footprint)), 1, 8));
  }
  fused_.assign(total, kNothing);
  parallel_for(static_cast<std::size_t>(points_.z()), threads, [&](std::size_t z) {
    for (std::size_t v = z * slice; v < (z + 1) * slice; ++v) {
      int seen = 0;
      const Vector3d world = position(v);
      for (std::size_t i = 0; i < pixel_.size(); ++i) {
        if (pixel_[i].empty()) continue;
        const RigCamera& c = rig.cameras[i];
        const std::optional<Eigen::Vector2d> at = project(c.model, c.cam_from_world * world);
        if (!at || !inside(c.model, *at)) continue;
        const int x = std::min(static_cast<int>(at->x() / c.model.width * sizes_[i].x()), sizes_[i].x() - 1),
                  y = std::min(static_cast<int>(at->y() / c.model.height * sizes_[i].y()), sizes_[i].y() - 1);
        pixel_[i][v] = static_cast<std::uint32_t>(y * sizes_[i].x() + x);
        ++seen;
      }
      counts_[v] = seen >= seen_by;
    }
  });
}

Vector3d OccupancyGrid::position(std::size_t v) const {
  const auto w = static_cast<std::size_t>(points_.x()), h = static_cast<std::size_t>(points_.y());
  return box_.min() + voxel_ * Vector3d(static_cast<double>(v % w) + 0.5,
                                        static_cast<double>(v / w % h) + 0.5,
                                        static_cast<double>(v / (w * h)) + 0.5);
}

void OccupancyGrid::fuse(std::span<const OddsPicture> odds, const OccupancyOptions& options) {
  FLOATSTAGE_CHECK(odds.size() == pixel_.size(), "odds of every camera");
  say_.assign(odds.size(), {});
  parallel_for(odds.size(), threads_, [&](std::size_t i) {
    if (odds[i].empty() || pixel_[i].empty()) return;
    FLOATSTAGE_CHECK(odds[i].width == sizes_[i].x() && odds[i].height == sizes_[i].y(), "odds of their size");
    say_[i].resize(odds[i].odds.size());
    std::transform(odds[i].odds.begin(), odds[i].odds.end(), say_[i].begin(),
                   [&](float o) { return worth(o, options); });
  });
  const auto slice = static_cast<std::size_t>(points_.x()) * static_cast<std::size_t>(points_.y());
  parallel_for(static_cast<std::size_t>(points_.z()), threads_, [&](std::size_t z) {
    for (std::size_t v = z * slice; v < (z + 1) * slice; ++v)
      fused_[v] = counts_[v] ? static_cast<float>(options.prior) : kNothing;
    for (std::size_t i = 0; i < say_.size(); ++i) {
      if (say_[i].empty()) continue;
      for (std::size_t v = z * slice; v < (z + 1) * slice; ++v)
        if (pixel_[i][v] != kUnseen) fused_[v] += say_[i][pixel_[i][v]];
    }
  });
}

std::vector<float> OccupancyGrid::silhouette(std::size_t i, bool own,
                                             std::span<const Eigen::Hyperplane<double, 3>> before) const {
  const int w = sizes_[i].x(), h = sizes_[i].y();
  std::vector<float> most(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), kNothing);
  if (pixel_[i].empty()) return most;
  for (std::size_t v = 0; v < fused_.size(); ++v) {
    if (!counts_[v] || pixel_[i][v] == kUnseen) continue;
    const auto beyond = [&](const Eigen::Hyperplane<double, 3>& plane) {
      return plane.signedDistance(position(v)) <= 0;
    };
    if (std::any_of(before.begin(), before.end(), beyond)) continue;
    float& m = most[pixel_[i][v]];
    m = std::max(m, fused_[v]);
  }
  if (!own && !say_[i].empty())  // the same for all voxels behind a pixel
    for (std::size_t p = 0; p < most.size(); ++p)
      if (most[p] > kNothing) most[p] -= say_[i][p];
  return closed(most, w, h, reach_[i]);
}

std::vector<float> OccupancyGrid::said_by_others(int camera) const {
  return silhouette(static_cast<std::size_t>(camera), false);
}

std::vector<float> OccupancyGrid::said_by_others_before(
    int camera, std::span<const Eigen::Hyperplane<double, 3>> planes) const {
  return silhouette(static_cast<std::size_t>(camera), false, planes);
}

std::vector<float> OccupancyGrid::said_by_all(int camera) const {
  return silhouette(static_cast<std::size_t>(camera), true);
}

Eigen::AlignedBox3d OccupancyGrid::subject_box(float above) const {
  Eigen::AlignedBox3d box;
  for (std::size_t v = 0; v < fused_.size(); ++v)
    if (fused_[v] > above) box.extend(position(v));
  if (!box.isEmpty())
    box = Eigen::AlignedBox3d(box.min() - Vector3d::Constant(voxel_ / 2),
                              box.max() + Vector3d::Constant(voxel_ / 2));
  return box;
}

std::size_t OccupancyGrid::occupied() const {
  return static_cast<std::size_t>(std::count_if(fused_.begin(), fused_.end(), [](float f) { return f > 0; }));
}

}  // namespace floatstage::recon
