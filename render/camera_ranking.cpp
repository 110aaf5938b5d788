#include "render/camera_ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "render/ray_kernels.h"

namespace floatstage::render {
namespace {

/// 1 in the middle of the picture, falling smoothly outside it: what the view shows decides.
double importance(const View& view, const Eigen::Vector3d& world) {
  const Eigen::Vector3d p = view.view_from_world * world;
  if (p.z() <= view.near_plane) return 1e-4;
  const CameraModel& m = view.model;
  const double x = (m.fx * p.x() / p.z() + m.cx - 0.5 * m.width) / (0.5 * m.width);
  const double y = (m.fy * p.y() / p.z() + m.cy - 0.5 * m.height) / (0.5 * m.height);
  const double r2 = x * x + y * y;
  return 1e-4 + 1 / (1 + r2 * r2);
}

}  // namespace

RankingSamples ranking_samples(const Mesh& mesh) {
  RankingSamples samples;
  const std::size_t stride = std::max<std::size_t>(1, mesh.triangle_count() / kRankingSamples);
  for (std::size_t t = 0; t < mesh.triangle_count(); t += stride)
    samples.push_back(mesh.positions[mesh.triangles[3 * t]]);
  return samples;
}

std::vector<double> mean_angles(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                                const View& view) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  std::vector<double> angles(cameras.size());
  double total = 0;
  for (const Eigen::Vector3f& sample : samples) {
    const Eigen::Vector3d p = sample.cast<double>();
    const double weight = importance(view, p);
    const Eigen::Vector3d to_view = (eye - p).normalized();
    total += weight;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const Eigen::Vector3d to_camera = (cameras[i].cam_from_world.center() - p).normalized();
      angles[i] += weight * 2 * std::asin(std::min(1.0, 0.5 * (to_view - to_camera).norm()));
    }
  }
  if (total > 0)
    for (double& a : angles) a /= total;
  return angles;
}

void CameraRanking::set(const std::vector<RigCamera>& cameras, const RankingSamples& samples) {
  samples_ = samples;
  lanes_ = (cameras.size() + kRayLanes - 1) / kRayLanes * kRayLanes;
  centers_.assign(3 * lanes_, 0.0);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Eigen::Vector3d center = cameras[i].cam_from_world.center();
    for (int axis = 0; axis < 3; ++axis) centers_[static_cast<std::size_t>(axis) * lanes_ + i] = center[axis];
  }
  rays_.resize(samples.size() * centers_.size());
  for (std::size_t s = 0; s < samples.size(); ++s)
    unit_rays(samples[s].cast<double>(), centers_.data(), lanes_, rays_.data() + s * centers_.size());

  by_place_.resize(cameras.size());
  std::iota(by_place_.begin(), by_place_.end(), 0);
  auto center = [&](int camera) {
    const double* x = centers_.data() + camera;
    return std::tuple(x[0], x[lanes_], x[2 * lanes_]);
  };
  std::sort(by_place_.begin(), by_place_.end(), [&](int a, int b) { return center(a) < center(b); });
}

std::span<const RankedCamera> CameraRanking::rank(const View& view) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  angles_.assign(lanes_, 0.0);
  double total = 0;
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const Eigen::Vector3d p = samples_[s].cast<double>();
    const double weight = importance(view, p);
    total += weight;
    add_angles((eye - p).normalized(), 2 * weight, rays_.data() + s * centers_.size(), lanes_,
               angles_.data());
  }
  ranked_.clear();
  for (const int camera : by_place_) {
    const double sum = angles_[static_cast<std::size_t>(camera)], angle = total > 0 ? sum / total : sum;
    ranked_.push_back({std::llround(angle * 1e9), static_cast<int>(ranked_.size()), camera, angle});
  }
  std::sort(ranked_.begin(), ranked_.end(), [](const RankedCamera& a, const RankedCamera& b) {
    return std::pair(a.nanoradians, a.place) < std::pair(b.nanoradians, b.place);
  });
  return ranked_;
}

}  // namespace floatstage::render
