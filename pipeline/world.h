#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/rig.h"

namespace floatstage::pipeline {

/// x_in_new = scale * rotation * x_in_old + translation.
struct WorldChange {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return scale * (rotation * x) + translation; }
};

/// The same cameras in the new world: every picture stays as it is.
Rig in_world(const Rig& rig, const WorldChange& new_from_old);

/// What is known of a world whose maker did not say z up, metres, floor at z = 0.
struct WorldOptions {
  std::string up;               ///< x, -x, y, -y, z, -z, or ring: as the cameras stand; empty: as it is
  std::optional<double> scale;  ///< metres in one of its units
  std::optional<double> floor;  ///< how high the floor lies along up, metres after `scale`; it becomes z = 0
  bool empty() const { return up.empty() && !scale && !floor; }
};

/// For flags: what WorldOptions::up may be.
std::vector<std::string> up_names();

/// The change that the options ask for. With up = ring the origin goes below the middle of the cameras'
/// circle too. InvalidArgument for a scale that is not positive and finite.
Result<WorldChange> world_change(const Rig& rig, const WorldOptions& options);

/// "the cameras stand 2.3 m around, 1.2 to 1.4 m above the floor": what a rig's world comes to, and a word
/// where its pictures show another up than z.
std::string describe_world(const Rig& rig);

}  // namespace floatstage::pipeline
