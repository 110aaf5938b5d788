#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "render/camera_choice.h"
#include "render/scene_impl.h"
#include "render/short_list.h"

namespace floatstage::render {

/// From where a picture was drawn, and from which photographs: what fields are asked for (flow_pair_at()).
struct FieldsOfPicture {
  Eigen::Vector3d eye;
  ShortList<int, kMostListed> cameras;  ///< indices into Scene::Impl::cameras
  std::vector<bool> wanted;             ///< of each: whether there are fields towards its image
};

/// A field that the picture before has, too.
struct RememberedField {
  std::size_t now, before;
  float share;  ///< of what was before, in what is now
};

/// The fields that two pictures of one scene have in common. The share is less than `share` where the view
/// turns fast: what stays of a field reaches no farther back, in the mean, than half way from one of its
/// cameras to the other, as the middle of the scene sees them.
std::vector<RememberedField> remembered_fields(const Scene::Impl& scene, const FieldsOfPicture& now,
                                               const FieldsOfPicture& before, double share);

/// The share of what was found for all photographs at once, in the picture before, that stays: limited in the
/// same way, by the mean angle between the cameras of `choice`.
double remembered_share(const Scene::Impl& scene, const Eigen::Vector3d& eye, const CameraChoice& choice,
                        const Eigen::Vector3d& eye_before, double share);

}  // namespace floatstage::render
