#include "core/synthetic/strands.h"

#include <array>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace floatstage::synthetic {
namespace {

using Eigen::Vector3d;

constexpr double kLagPerNode = 0.016;  // seconds

Vector3d random_direction(Random& random) {
  const double z = random.uniform(-1, 1), azimuth = random.uniform(0, 2 * std::numbers::pi),
               r = std::sqrt(1 - z * z);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

}  // namespace

std::vector<Strand> loose_strands(std::uint64_t seed) {
  Random random(mix(seed ^ 0x57BA4D));
  std::vector<Strand> strands;
  auto add = [&](Bone bone, const Vector3d& root, const Vector3d& direction, double length, double radius,
                 double limpness, int color) {
    strands.push_back({bone, root, direction.normalized(), length, radius, limpness,
                       random.uniform(0, 2 * std::numbers::pi), random.uniform(), color});
  };
  for (int i = 0; i < 90; ++i) {  // the tail
    const Vector3d spread = random_direction(random);
    add(Bone::Head, Vector3d(0, -0.108, 0.165) + 0.014 * spread, Vector3d(0, -1, 0.55) + 0.34 * spread,
        random.uniform(0.24, 0.40), random.uniform(0.0010, 0.0014), random.uniform(1.6, 2.4), 0);
  }
  for (int i = 0; i < 60; ++i) {  // fly-away hairs over the crown and the temples
    Vector3d u = random_direction(random);
    u.z() = std::abs(u.z()) * 0.9 + 0.1;
    u.y() -= 0.25;
    u.normalize();
    add(Bone::Head, Vector3d(0, -0.008, 0.156) + u.cwiseProduct(Vector3d(0.083, 0.104, 0.109)),
        u + 0.5 * random_direction(random), random.uniform(0.05, 0.15), random.uniform(0.0009, 0.0012),
        random.uniform(1.0, 2.6), 0);
  }
  for (int side : {1, -1}) {  // ribbons at the wrists
    const Bone bone = side > 0 ? Bone::ForearmRight : Bone::ForearmLeft;
    for (int i = 0; i < 5; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.3) / 5;
      const Vector3d out(std::cos(angle), std::sin(angle), 0);
      add(bone, Vector3d(0, 0, 0.205) + 0.027 * out, out + Vector3d(0, 0, 0.3), random.uniform(0.18, 0.34),
          0.0015, 2.0, 1 + (i + (side > 0)) % 3);
    }
  }
  for (int i = 0; i < 6; ++i)  // at the belt, on the right hip
    add(Bone::Pelvis, Vector3d(0.168, 0.01 * (i - 3), -0.035), Vector3d(1, 0.12 * (i - 2.5), -0.3),
        random.uniform(0.25, 0.42), 0.0015, 2.2, 1 + i % 3);
  for (int i = 0; i < 4; ++i)  // the ends of the hairband
    add(Bone::Head, Vector3d(0.01 * (i - 1.5), -0.112, 0.155), Vector3d(0.3 * (i - 1.5), -1, 0.1),
        random.uniform(0.28, 0.38), 0.0015, 1.8, 3);
  return strands;
}

std::vector<std::uint32_t> strand_triangles() {
  std::vector<std::uint32_t> triangles;
  for (int node = 0; node + 1 < kStrandNodes; ++node) {
    for (int k = 0; k < kStrandSides; ++k) {
      const auto a = static_cast<std::uint32_t>(node * kStrandSides + k);
      const auto b = static_cast<std::uint32_t>(node * kStrandSides + (k + 1) % kStrandSides);
      triangles.insert(triangles.end(), {a, b, b + kStrandSides, a, b + kStrandSides, a + kStrandSides});
    }
  }
  return triangles;
}

std::vector<SkeletonPose> strand_trail(const std::function<SkeletonPose(double)>& pose_at, double seconds) {
  std::vector<SkeletonPose> trail;
  for (int node = 0; node < kStrandNodes; ++node) trail.push_back(pose_at(seconds - kLagPerNode * node));
  return trail;
}

void place_strand(const Strand& strand, const std::vector<SkeletonPose>& trail, double seconds,
                  Eigen::Vector3f* vertices) {
  std::array<Vector3d, kStrandNodes> nodes;
  Vector3d reach = Vector3d::Zero();
  const double step = strand.length / (kStrandNodes - 1);
  const Vector3d down = -Vector3d::UnitZ();
  for (int k = 0; k < kStrandNodes; ++k) {
    const double s = static_cast<double>(k) / (kStrandNodes - 1);
    const BonePose& bone = trail[static_cast<std::size_t>(k)][strand.bone];
    nodes[static_cast<std::size_t>(k)] = bone * strand.root + reach;
    const double hang = 1 - std::exp(-strand.limpness * 1.6 * s);
    const double swing = 5.1 * seconds + strand.phase - 2.2 * s;
    const Vector3d sway(0.22 * s * std::sin(swing), 0.22 * s * std::cos(0.83 * swing + strand.phase), 0);
    reach +=
        step * ((1 - hang) * (bone.world_from_bone * strand.direction) + hang * down + sway).normalized();
  }
  Vector3d across = (nodes[1] - nodes[0]).unitOrthogonal();
  for (int k = 0; k < kStrandNodes; ++k) {
    const Vector3d along = (nodes[static_cast<std::size_t>(std::min(k + 1, kStrandNodes - 1))] -
                            nodes[static_cast<std::size_t>(std::max(k - 1, 0))])
                               .normalized();
    // The direction across is carried from node to node, so that the prism does not twist to nothing.
    across = (across - along * along.dot(across)).normalized();
    const Vector3d other = along.cross(across);
    const double radius = strand.radius * (k + 1 == kStrandNodes ? 0.4 : 1.0);
    for (int side = 0; side < kStrandSides; ++side) {
      const double angle = 2 * std::numbers::pi * side / kStrandSides;
      const Vector3d p =
          nodes[static_cast<std::size_t>(k)] + radius * (std::cos(angle) * across + std::sin(angle) * other);
      vertices[k * kStrandSides + side] = p.cast<float>();
    }
  }
}

}  // namespace floatstage::synthetic
