#include "core/synthetic/skeleton.h"

#include <cmath>

#include <gtest/gtest.h>

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;

TEST(BendJoint, KeepsBothLengthsAndBendsTowardsThePole) {
  Vector3d target(0.1, 0.2, -0.45);
  const Vector3d wanted = target, joint = bend_joint({0, 0, 0}, target, 0.3, 0.25, {0, 1, 0});
  EXPECT_EQ(target, wanted) << "within reach, the target stays";
  EXPECT_NEAR(joint.norm(), 0.3, 1e-12);
  EXPECT_NEAR((target - joint).norm(), 0.25, 1e-12);
  EXPECT_GT(joint.dot(Vector3d(0, 1, 0)), (target * joint.dot(target) / target.squaredNorm()).y());
}

TEST(BendJoint, MovesATargetOutOfReachIntoReach) {
  Vector3d target(0, 0, -5);
  const Vector3d joint = bend_joint({0, 0, 0}, target, 0.3, 0.25, {0, 1, 0});
  EXPECT_LT(target.norm(), 0.55);
  EXPECT_GT(target.norm(), 0.54);
  EXPECT_NEAR((target - joint).norm(), 0.25, 1e-12);
}

class EverySeed : public testing::TestWithParam<std::uint64_t> {
 protected:
  const Choreography dance = choreography(GetParam());
  const BodyMeasures body;
};

TEST_P(EverySeed, KeepsBonesAtTheirLengths) {
  for (double t = 0; t < 4; t += 0.13) {
    const SkeletonPose pose = pose_at(dance, body, t);
    auto length = [&](Bone a, Bone b) { return (pose[a].origin - pose[b].origin).norm(); };
    EXPECT_NEAR(length(Bone::UpperArmLeft, Bone::ForearmLeft), body.upper_arm, 1e-9);
    EXPECT_NEAR(length(Bone::ForearmRight, Bone::HandRight), body.forearm, 1e-9);
    EXPECT_NEAR(length(Bone::ThighRight, Bone::ShinRight), body.thigh, 1e-9);
    EXPECT_NEAR(length(Bone::ShinLeft, Bone::FootLeft), body.shin, 1e-9);
    for (const BonePose& bone : pose.bones) EXPECT_NEAR(bone.world_from_bone.norm(), 1, 1e-9);
  }
}

TEST_P(EverySeed, KeepsAFootFlatOnTheFloor) {
  for (double t = 0; t < 4; t += 0.07) {
    const SkeletonPose pose = pose_at(dance, body, t);
    auto flat = [&](Bone foot) {
      return std::abs(pose[foot].origin.z() - body.ankle_height) < 0.002 &&
             (pose[foot].world_from_bone * Vector3d::UnitZ()).z() > 0.9999;
    };
    EXPECT_TRUE(flat(Bone::FootLeft) || flat(Bone::FootRight)) << t;
  }
}

TEST_P(EverySeed, BendsElbowsAndKneesTheWayPeopleDo) {
  for (double t = 0; t < 4; t += 0.11) {
    const SkeletonPose pose = pose_at(dance, body, t);
    const Vector3d front = pose[Bone::Pelvis].world_from_bone * Vector3d::UnitY();
    for (auto [hip, knee, ankle] : {std::tuple(Bone::ThighLeft, Bone::ShinLeft, Bone::FootLeft),
                                    std::tuple(Bone::ThighRight, Bone::ShinRight, Bone::FootRight)}) {
      const Vector3d middle = (pose[hip].origin + pose[ankle].origin) / 2;
      EXPECT_GT((pose[knee].origin - middle).dot(front), 0) << "a knee bends forwards";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, EverySeed, testing::Values(1, 2, 7, 42));

}  // namespace
}  // namespace floatstage::synthetic
