#include "render/camera_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace floatstage {
namespace {

constexpr int kStandIns = 3;

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

double fade(double angle, double threshold) {
  return threshold > 0 ? std::max(0.0, 1 - angle / threshold) : 0.0;
}

}  // namespace

CameraChoice choose_cameras(const std::vector<RigCamera>& cameras,
                            const std::vector<Eigen::Vector3f>& samples, const View& view, int count) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  std::vector<double> angle(cameras.size(), 0.0);
  double total = 0;
  for (const Eigen::Vector3f& sample : samples) {
    const Eigen::Vector3d p = sample.cast<double>();
    const double weight = importance(view, p);
    const Eigen::Vector3d to_view = (eye - p).normalized();
    total += weight;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const Eigen::Vector3d to_camera = (cameras[i].cam_from_world.center() - p).normalized();
      angle[i] += weight * 2 * std::asin(std::min(1.0, 0.5 * (to_view - to_camera).norm()));
    }
  }
  if (total > 0)
    for (double& a : angle) a /= total;

  std::vector<int> order(cameras.size());
  std::iota(order.begin(), order.end(), 0);
  auto key = [&](int i) {
    const auto c = static_cast<std::size_t>(i);
    const Eigen::Vector3d center = cameras[c].cam_from_world.center();
    // Rounded, so that cameras at equal angles do not swap with the last bit of a sum.
    return std::tuple(std::llround(angle[c] * 1e9), center.x(), center.y(), center.z());
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });

  CameraChoice choice;
  choice.chosen = std::min<std::size_t>(static_cast<std::size_t>(count), order.size());
  const std::size_t listed =
      std::min({order.size(), choice.chosen + kStandIns, static_cast<std::size_t>(kMostListed)});
  choice.listed.assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(listed));
  auto angle_of_rank = [&](std::size_t rank) { return angle[static_cast<std::size_t>(order[rank])]; };
  for (std::size_t i = 0; i < listed; ++i) {
    const double a = angle_of_rank(i);
    const bool all_chosen = choice.chosen == order.size(), all_listed = listed == order.size();
    choice.fade.push_back(static_cast<float>(i >= choice.chosen ? 0
                                             : all_chosen       ? 1
                                                                : fade(a, angle_of_rank(choice.chosen))));
    choice.stand_in_fade.push_back(static_cast<float>(all_listed ? 1 : fade(a, angle_of_rank(listed))));
  }
  return choice;
}

}  // namespace floatstage
