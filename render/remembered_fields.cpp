#include "render/remembered_fields.h"

#include <algorithm>
#include <cmath>

#include "render/pairwise_flows.h"

namespace floatstage::render {
namespace {

constexpr double kReach = 0.5;  // of the way from camera to camera

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// What stays of a picture that is `turned` away, for cameras that are `apart`. Shares s, s², … of views that
// are one turn, two turns … back: the mean of these is turned / (1 - s).
double stays_of(double share, double turned, double apart) {
  const double reach = kReach * apart, most = turned < reach ? 1 - turned / reach : turned > 0 ? 0.0 : 1.0;
  return std::min(share, most);
}

Eigen::Vector3d middle_of(const Scene::Impl& scene) { return scene.box.center().cast<double>(); }

double angle_between(const Scene::Impl& scene, int a, int b) {
  const auto from_middle = [&](int camera) -> Eigen::Vector3d {
    return scene.cameras[static_cast<std::size_t>(camera)].cam_from_world.center() - middle_of(scene);
  };
  return angle_between(from_middle(a), from_middle(b));
}

std::size_t slot_of(const FieldsOfPicture& picture, int camera) {
  return static_cast<std::size_t>(std::find(picture.cameras.begin(), picture.cameras.end(), camera) -
                                  picture.cameras.begin());
}

}  // namespace

std::vector<RememberedField> remembered_fields(const Scene::Impl& scene, const FieldsOfPicture& now,
                                               const FieldsOfPicture& before, double share) {
  const Eigen::Vector3d middle = middle_of(scene);
  const double turned = angle_between(now.eye - middle, before.eye - middle);
  const std::size_t count = now.cameras.size(), there = before.cameras.size();
  std::vector<RememberedField> common;
  for (std::size_t index = 0; count > 1 && index < count * (count - 1); ++index) {
    const FlowPair pair = flow_pair_at(index, count);
    const int from = now.cameras[pair.first], to = now.cameras[pair.second];
    const FlowPair was{slot_of(before, from), slot_of(before, to)};
    if (!now.wanted[pair.second] || was.first == there || was.second == there || !before.wanted[was.second])
      continue;
    const double stays = stays_of(share, turned, angle_between(scene, from, to));
    if (stays > 0) common.push_back({index, flow_index_of(was, there), static_cast<float>(stays)});
  }
  return common;
}

double remembered_share(const Scene::Impl& scene, const Eigen::Vector3d& eye, const CameraChoice& choice,
                        const Eigen::Vector3d& eye_before, double share) {
  double apart = 0, all = 0;
  for (std::size_t i = 0; i < choice.chosen; ++i)
    for (std::size_t j = i + 1; j < choice.chosen; ++j) {
      const double both = static_cast<double>(choice.fade[i]) * static_cast<double>(choice.fade[j]);
      apart += both * angle_between(scene, choice.listed[i], choice.listed[j]);
      all += both;
    }
  const Eigen::Vector3d middle = middle_of(scene);
  return all > 0 ? stays_of(share, angle_between(eye - middle, eye_before - middle), apart / all) : 0;
}

}  // namespace floatstage::render
