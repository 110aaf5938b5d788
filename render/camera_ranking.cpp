#include "render/camera_ranking.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include "core/camera.h"
#include "render/enough.h"
#include "render/ray_kernels.h"

namespace floatstage::render {
namespace {

constexpr double kRim = 0.02;    // of a picture's width, beyond its border
constexpr double kFacing = 0.2;  // cosine above which a camera looks at a surface, not along it
/// Of the weights in rank_rest(): what the blended cameras show. It tells cameras that are as good apart.
constexpr double kShown = 0.02;

RankingSample sample_of(const Mesh& mesh, const std::uint32_t* corners) {
  const Eigen::Vector3f& a = mesh.positions[corners[0]];
  const Eigen::Vector3f normal =
      (mesh.positions[corners[1]] - a).cross(mesh.positions[corners[2]] - a).stableNormalized();
  return {a, normal};
}

/// 1 where a camera looks at a surface, falling to 0 where it looks along it.
double facing(const RigCamera& camera, const Eigen::Vector3d& p, const Eigen::Vector3f& normal) {
  const Eigen::Vector3d to_camera = (camera.cam_from_world.center() - p).normalized();
  return std::clamp(normal.cast<double>().dot(to_camera) / kFacing, 0.0, 1.0);
}

}  // namespace

double importance(const View& view, const Eigen::Vector3d& world) {
  const Eigen::Vector3d p = view.view_from_world * world;
  if (p.z() <= view.near_plane) return 1e-4;
  const CameraModel& m = view.model;
  const double x = (m.fx * p.x() / p.z() + m.cx - 0.5 * m.width) / (0.5 * m.width);
  const double y = (m.fy * p.y() / p.z() + m.cy - 0.5 * m.height) / (0.5 * m.height);
  const double r2 = x * x + y * y;
  return 1e-4 + 1 / (1 + r2 * r2);
}

RankingSamples ranking_samples(const Mesh& mesh) {
  RankingSamples samples;
  const std::size_t stride = std::max<std::size_t>(1, mesh.triangle_count() / kRankingSamples);
  for (std::size_t t = 0; t < mesh.triangle_count(); t += stride)
    samples.push_back(sample_of(mesh, mesh.triangles.data() + 3 * t));
  return samples;
}

std::vector<double> mean_angles(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                                const View& view) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  std::vector<double> angles(cameras.size());
  double total = 0;
  for (const RankingSample& sample : samples) {
    const Eigen::Vector3d p = sample.point.cast<double>();
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

double in_picture(const RigCamera& camera, const Eigen::Vector3d& world) {
  const CameraModel& m = camera.model;
  const std::optional<Eigen::Vector2d> pixel = project(m, camera.cam_from_world * world);
  if (!pixel) return 0;
  const double within =
      std::min(std::min(pixel->x(), m.width - pixel->x()), std::min(pixel->y(), m.height - pixel->y()));
  return std::clamp(1 + within / (kRim * m.width), 0.0, 1.0);
}

double shows(const RigCamera& camera, const RankingSample& sample) {
  const Eigen::Vector3d p = sample.point.cast<double>();
  return in_picture(camera, p) * facing(camera, p, sample.normal);
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
  pictured_.assign(samples.size() * lanes_, 0.0);
  shown_ = pictured_;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Eigen::Vector3d p = samples[s].point.cast<double>();
    unit_rays(p, centers_.data(), lanes_, rays_.data() + s * centers_.size());
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const std::size_t at = s * lanes_ + i;
      pictured_[at] = in_picture(cameras[i], p);
      shown_[at] = pictured_[at] * facing(cameras[i], p, samples[s].normal);
    }
  }

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
    const Eigen::Vector3d p = samples_[s].point.cast<double>();
    const double weight = importance(view, p);
    total += weight;
    add_angles((eye - p).normalized(), 2 * weight, rays_.data() + s * centers_.size(), lanes_,
               angles_.data());
  }
  order(total, ranked_);
  return ranked_;
}

CameraRanking::Rest CameraRanking::rank_rest(const View& view, std::span<const BlendedCamera> blended) {
  double all = 0, lacking = 0, total = 0;
  for (const BlendedCamera& b : blended) all += b.fade;
  ShortList<double, 2 * kRankingSamples> weights, lacks;
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const double* pictured = pictured_.data() + s * lanes_;
    double have = 0;
    for (const BlendedCamera& b : blended) have += b.fade * pictured[static_cast<std::size_t>(b.camera)];
    const double weight = importance(view, samples_[s].point.cast<double>());
    weights.push_back(weight);
    lacks.push_back(weight * (1 - std::min(1.0, have / (kEnough * all))));
    lacking += lacks[s];
    total += weight;
  }
  if (!(lacking > 0)) return {0, ranked_};

  const Eigen::Vector3d eye = view.view_from_world.center();
  angles_.assign(lanes_, 0.0);
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    const Eigen::Vector3d to_view = (eye - samples_[s].point.cast<double>()).normalized();
    add_angles(to_view, 2 * (lacks[s] + kShown * weights[s]), rays_.data() + s * centers_.size(), lanes_,
               angles_.data());
    const double* shown = shown_.data() + s * lanes_;
    for (std::size_t i = 0; i < lanes_; ++i) angles_[i] += lacks[s] * std::numbers::pi * (1 - shown[i]);
  }
  order(lacking + kShown * total, rest_);
  return {lacking / total, rest_};
}

// By the lanes' angles, of which `total` weights were summed.
void CameraRanking::order(double total, std::vector<RankedCamera>& ranked) const {
  ranked.clear();
  for (const int camera : by_place_) {
    const double sum = angles_[static_cast<std::size_t>(camera)], angle = total > 0 ? sum / total : sum;
    ranked.push_back({std::llround(angle * 1e9), static_cast<int>(ranked.size()), camera, angle});
  }
  std::sort(ranked.begin(), ranked.end(), [](const RankedCamera& a, const RankedCamera& b) {
    return std::pair(a.nanoradians, a.place) < std::pair(b.nanoradians, b.place);
  });
}

}  // namespace floatstage::render
