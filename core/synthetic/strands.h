#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/synthetic/skeleton.h"

namespace floatstage::synthetic {

/// A loose hair or ribbon, two to three millimetres wide: thinner than a pixel, so that it covers pixels only
/// partly.
struct Strand {
  Bone bone = Bone::Head;
  Eigen::Vector3d root = Eigen::Vector3d::Zero();        ///< in the bone's coordinates
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< in which it leaves, in the bone's coordinates
  double length = 0.2, radius = 0.0012;                  ///< metres
  double limpness = 1.5;                                 ///< how soon it hangs down
  double phase = 0;                                      ///< of its own swaying
  double shade = 0.5;                                    ///< 0…1: individual tint
  int color = 0;                                         ///< 0 hair, 1…3 ribbons
};

inline constexpr int kStrandNodes = 14, kStrandSides = 3, kStrandVertices = kStrandNodes * kStrandSides;

/// Every strand of the performer: the tail of hair, fly-away hairs, ribbons at wrists, belt and hairband.
std::vector<Strand> loose_strands(std::uint64_t seed);

/// Triangles of one strand, a three-sided prism, counter-clockwise outside, over its kStrandVertices
/// vertices.
std::vector<std::uint32_t> strand_triangles();

/// The poses that a strand's nodes follow: each node a little later than the one before, so strands trail
/// behind.
std::vector<SkeletonPose> strand_trail(const std::function<SkeletonPose(double)>& pose_at, double seconds);

/// Writes the strand's kStrandVertices world positions.
void place_strand(const Strand& strand, const std::vector<SkeletonPose>& trail, double seconds,
                  Eigen::Vector3f* vertices);

}  // namespace floatstage::synthetic
