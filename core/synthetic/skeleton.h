#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace floatstage::synthetic {

/// The performer's bones. Torso, head and feet: x to the performer's right, y to the front, z up. Limbs: z
/// along the bone away from the body, y towards where the joint's outside points.
enum class Bone {
  Pelvis,
  Chest,
  Head,
  UpperArmRight,
  ForearmRight,
  HandRight,
  UpperArmLeft,
  ForearmLeft,
  HandLeft,
  ThighRight,
  ShinRight,
  FootRight,
  ThighLeft,
  ShinLeft,
  FootLeft,
};
inline constexpr int kBoneCount = 15;

/// Metres of a body 1.75 m tall.
struct BodyMeasures {
  double pelvis_height = 0.915, waist = 0.12, neck = 0.45;
  double shoulder_half_width = 0.172, shoulder_height = 0.355, upper_arm = 0.275, forearm = 0.245;
  double hip_half_width = 0.09, hip_drop = 0.03, thigh = 0.42, shin = 0.41, ankle_height = 0.085;
};

struct BonePose {
  Eigen::Quaterniond world_from_bone = Eigen::Quaterniond::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< the joint at the bone's near end, world
  Eigen::Vector3d operator*(const Eigen::Vector3d& in_bone) const {
    return world_from_bone * in_bone + origin;
  }
};

struct SkeletonPose {
  std::array<BonePose, kBoneCount> bones;
  BonePose& operator[](Bone b) { return bones[static_cast<std::size_t>(b)]; }
  const BonePose& operator[](Bone b) const { return bones[static_cast<std::size_t>(b)]; }
};

/// What the seed decides about the dance.
struct Choreography {
  double start = 0;     ///< radians of the beat at time 0
  double turn = 0;      ///< radians of the slow turn at time 0
  double period = 1.6;  ///< seconds a beat
};
Choreography choreography(std::uint64_t seed);

/// Where every bone is at `seconds`: smooth in time, at least one foot flat on the floor, facing +y on the
/// average.
SkeletonPose pose_at(const Choreography& dance, const BodyMeasures& body, double seconds);

/// The middle joint of two bones of the given lengths from `root` towards `target`, bent towards `pole`. A
/// target out of reach is moved along its direction into reach; `target` returns where the far end really is.
Eigen::Vector3d bend_joint(const Eigen::Vector3d& root, Eigen::Vector3d& target, double near_length,
                           double far_length, const Eigen::Vector3d& pole);

}  // namespace floatstage::synthetic
