#include "render/camera_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

namespace floatstage::render {
namespace {

constexpr int kStandIns = 3;
constexpr double kAsNear =
    1.75;  // times the nearest one's angle: below 2, where a ring's second neighbours stand
constexpr double kLeastFade = 1e-6;  // where all of a list are as far as the next one, somebody has to count

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

CameraChoice choose_cameras(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                            const View& view, int count, const std::vector<bool>& pictured,
                            CameraRanking& memory) {
  const Eigen::Vector3d eye = view.view_from_world.center();
  std::vector<double>& angle = memory.angle;
  angle.assign(cameras.size(), 0.0);
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

  std::vector<int>& order = memory.order;
  order.resize(cameras.size());
  std::iota(order.begin(), order.end(), 0);
  auto key = [&](int i) {
    const auto c = static_cast<std::size_t>(i);
    const Eigen::Vector3d center = cameras[c].cam_from_world.center();
    // Rounded, so that cameras at equal angles do not swap with the last bit of a sum.
    return std::tuple(std::llround(angle[c] * 1e9), center.x(), center.y(), center.z());
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });

  // The ranks of the cameras with a picture.
  std::vector<std::size_t>& usable = memory.usable;
  usable.clear();
  for (std::size_t rank = 0; rank < order.size(); ++rank)
    if (pictured.empty() || pictured[static_cast<std::size_t>(order[rank])]) usable.push_back(rank);

  CameraChoice choice;
  auto angle_of = [&](std::size_t rank) { return angle[static_cast<std::size_t>(order[rank])]; };
  const auto blended = static_cast<std::size_t>(count), asked = std::min(blended, usable.size()),
             most = std::min({usable.size(), 2 * blended, static_cast<std::size_t>(kMostListed)});
  const double as_near = count > 1 && !order.empty() ? kAsNear * angle_of(0) : 0;
  choice.chosen = asked;
  while (choice.chosen < most && angle_of(usable[choice.chosen]) < as_near) ++choice.chosen;
  const std::size_t listed =
      std::min({usable.size(), choice.chosen + kStandIns, static_cast<std::size_t>(kMostListed)});
  // A fade ends at the camera that follows the last of its list, with a picture or without.
  auto end_of_fade = [&](std::size_t members) -> std::optional<double> {
    const std::size_t rank = members == 0 ? 0 : usable[members - 1] + 1;
    if (rank >= order.size()) return std::nullopt;
    return angle_of(rank);
  };
  const std::optional<double> listed_end = end_of_fade(listed);
  std::optional<double> chosen_end = end_of_fade(choice.chosen);
  if (choice.chosen > asked) chosen_end = std::min(as_near, chosen_end.value_or(as_near));
  for (std::size_t i = 0; i < listed; ++i) {
    const int camera = order[usable[i]];
    const double a = angle[static_cast<std::size_t>(camera)];
    choice.listed.push_back(camera);
    choice.fade.push_back(static_cast<float>(i >= choice.chosen ? 0 : chosen_end ? fade(a, *chosen_end) : 1));
    choice.stand_in_fade.push_back(
        static_cast<float>(listed_end ? std::max(kLeastFade, fade(a, *listed_end)) : 1));
  }
  return choice;
}

RankingSamples ranking_samples(const Mesh& mesh) {
  RankingSamples samples;
  const std::size_t stride = std::max<std::size_t>(1, mesh.triangle_count() / kRankingSamples);
  for (std::size_t t = 0; t < mesh.triangle_count(); t += stride)
    samples.push_back(mesh.positions[mesh.triangles[3 * t]]);
  return samples;
}

}  // namespace floatstage::render
