#pragma once

#include <cstdint>
#include <optional>

#include "core/check.h"
#include "core/rig.h"
#include "recon/mesh/mesh_check.h"
#include "recon/visual_hull.h"

namespace floatstage {

/// Where a camera stands that six bytes place; nothing when it would look at itself. `next` gives the next
/// byte of the fuzzer's input.
template <typename Next>
std::optional<Rigid3> pose_from(Next&& next) {
  const auto coordinate = [&] { return (static_cast<std::uint8_t>(next()) - 127.5) / 40; };
  double c[6];
  for (double& value : c) value = coordinate();
  const Eigen::Vector3d eye(c[0], c[1], c[2]), target = 0.1 * Eigen::Vector3d(c[3], c[4], c[5]);
  if ((eye - target).norm() < 0.1) return std::nullopt;
  return look_at(eye, target, Eigen::Vector3d(0.1, 0.3, 1));
}

/// What holds for any hull: a closed, manifold mesh or a sentence about the input.
inline void claim_closed_or_refused(const Result<recon::HullReport>& hull) {
  if (!hull) {
    FLOATSTAGE_CHECK(hull.error().code == ErrorCode::BadData, "an error that is not about the input");
    return;
  }
  const recon::MeshCheck mesh = recon::check_mesh(hull->mesh);
  FLOATSTAGE_CHECK(mesh.watertight && mesh.manifold && mesh.oriented, "an open hull: " + mesh.summary());
}

}  // namespace floatstage
