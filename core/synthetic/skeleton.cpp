#include "core/synthetic/skeleton.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace floatstage::synthetic {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond turned(double yaw, double pitch, double roll) {
  return Quaterniond(AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitX()) *
                     AngleAxisd(roll, Vector3d::UnitY()));
}

// z along the bone, y as near to `outside` as that allows.
Quaterniond along(const Vector3d& direction, const Vector3d& outside) {
  Eigen::Matrix3d m;
  m.col(2) = direction.normalized();
  m.col(1) = (outside - m.col(2) * m.col(2).dot(outside)).normalized();
  m.col(0) = m.col(1).cross(m.col(2));
  return Quaterniond(m);
}

void place_limb(SkeletonPose& pose, Bone near_bone, Bone far_bone, Bone end_bone, const Vector3d& root,
                Vector3d target, double near_length, double far_length, const Vector3d& pole) {
  const Vector3d joint = bend_joint(root, target, near_length, far_length, pole);
  pose[near_bone] = {along(joint - root, pole), root};
  pose[far_bone] = {along(target - joint, pole), joint};
  pose[end_bone] = {pose[far_bone].world_from_bone, target};
}

}  // namespace

Vector3d bend_joint(const Vector3d& root, Vector3d& target, double near_length, double far_length,
                    const Vector3d& pole) {
  const Vector3d direction = (target - root).normalized();
  const double reach = std::clamp((target - root).norm(), std::abs(near_length - far_length) + 0.05,
                                  0.995 * (near_length + far_length));
  target = root + direction * reach;
  const double along_direction =
      (near_length * near_length - far_length * far_length + reach * reach) / (2 * reach);
  const double aside =
      std::sqrt(std::max(0.0, near_length * near_length - along_direction * along_direction));
  const Vector3d bend = (pole - direction * direction.dot(pole)).normalized();
  return root + direction * along_direction + bend * aside;
}

Choreography choreography(std::uint64_t seed) {
  Random random(mix(seed ^ 0xDA7CE));
  Choreography dance;
  dance.start = random.uniform(0, 2 * std::numbers::pi);
  dance.turn = random.uniform(-0.4, 0.4);
  dance.period = random.uniform(1.5, 1.8);
  return dance;
}

SkeletonPose pose_at(const Choreography& dance, const BodyMeasures& body, double seconds) {
  const double beat = dance.start + 2 * std::numbers::pi * seconds / dance.period,
               slow = beat / 2 + dance.turn;
  const double s = std::sin(beat), c2 = std::cos(2 * beat);
  SkeletonPose pose;

  // The weight is over the standing foot, and lowest when both feet are down.
  BonePose& pelvis = pose[Bone::Pelvis];
  pelvis.origin = {-0.06 * s, 0.02 * std::sin(2 * beat), body.pelvis_height - 0.022 - 0.016 * c2};
  pelvis.world_from_bone = turned(0.22 * std::sin(slow), 0.03, 0.07 * s);
  BonePose& chest = pose[Bone::Chest];
  chest.origin = pelvis * Vector3d(0, 0, body.waist);
  chest.world_from_bone = pelvis.world_from_bone *
                          turned(0.30 * std::sin(slow + 0.7), -0.05 - 0.06 * std::sin(2 * beat), -0.13 * s);
  BonePose& head = pose[Bone::Head];
  head.origin = chest * Vector3d(0, 0.005, body.neck);
  head.world_from_bone = chest.world_from_bone *
                         turned(-0.25 * std::sin(slow + 0.4), 0.04 + 0.08 * std::sin(2 * beat + 1), 0.12 * s);

  auto arm = [&](double side, Bone near_bone, Bone far_bone, Bone end_bone, const Vector3d& hand,
                 const Vector3d& pole) {
    const double lift = 0.03 * std::clamp(hand.z() / 0.4, -0.5, 1.0);  // the shoulder follows the hand
    const Vector3d shoulder(side * body.shoulder_half_width, -0.005, body.shoulder_height + lift);
    const Vector3d out(side, 1, 1);
    place_limb(pose, near_bone, far_bone, end_bone, chest * shoulder,
               chest * (shoulder + hand.cwiseProduct(out)), body.upper_arm, body.forearm,
               chest.world_from_bone * pole.cwiseProduct(out));
  };
  // The right arm swings across the chest, the left one waves beside the head. First number: outwards.
  arm(1, Bone::UpperArmRight, Bone::ForearmRight, Bone::HandRight,
      {0.10 + 0.24 * std::sin(beat + 0.5), 0.27 + 0.07 * std::cos(beat), -0.16 + 0.17 * std::sin(beat + 1.4)},
      {0.7, -0.5, -0.6});
  arm(-1, Bone::UpperArmLeft, Bone::ForearmLeft, Bone::HandLeft,
      {0.29 + 0.10 * std::sin(beat + 2), 0.10 + 0.12 * std::sin(beat + 1),
       0.16 + 0.22 * std::sin(beat + 0.9)},
      {0.6, -0.3, -0.8});
  BonePose& right_hand = pose[Bone::HandRight];
  BonePose& left_hand = pose[Bone::HandLeft];
  right_hand.world_from_bone = right_hand.world_from_bone * turned(0.5, 0.30 * std::sin(beat + 2), 0.15 * s);
  left_hand.world_from_bone = left_hand.world_from_bone * turned(-0.9, 0.10, 0.45 * std::sin(2 * beat));

  auto leg = [&](double side, Bone near_bone, Bone far_bone, Bone end_bone) {
    const double up = std::max(0.0, side * s), raised = up * up;
    const Vector3d ankle(side * (0.13 + 0.07 * raised), 0.02 + 0.16 * raised,
                         body.ankle_height + 0.15 * raised);
    const Vector3d pole = pelvis.world_from_bone * Vector3d(0.25 * side, 1, 0);
    place_limb(pose, near_bone, far_bone, end_bone,
               pelvis * Vector3d(side * body.hip_half_width, 0, -body.hip_drop), ankle, body.thigh, body.shin,
               pole);
    // Toes outwards; a raised foot points its toes down.
    pose[end_bone].world_from_bone = turned(-side * 0.25, -0.45 * raised, 0);
  };
  leg(1, Bone::ThighRight, Bone::ShinRight, Bone::FootRight);
  leg(-1, Bone::ThighLeft, Bone::ShinLeft, Bone::FootLeft);
  return pose;
}

}  // namespace floatstage::synthetic
