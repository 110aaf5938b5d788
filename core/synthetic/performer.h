#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/synthetic/materials.h"
#include "core/synthetic/shell.h"
#include "core/synthetic/skeleton.h"
#include "core/synthetic/stage.h"
#include "core/synthetic/strands.h"

namespace floatstage::synthetic {

/// A shell on its bones. Rest coordinates are those of `near_bone`; beyond `joint_z` (over a length of
/// `blend` metres) the shell follows `far_bone`, whose origin is the joint.
struct Part {
  Material material = Material::Skin;
  int variant = 0;
  Bone near_bone = Bone::Pelvis, far_bone = Bone::Pelvis;
  double joint_z = 0, blend = 0;  ///< blend 0: rigid on near_bone
  std::uint32_t first_vertex = 0, vertices = 0;
  int body = 0;  ///< whose it is
};

/// The surface of the performer, or of two: what never changes (topology, texture coordinates), and where it
/// is at an instant. Shells come first in every array, strands after them.
class Performer {
 public:
  explicit Performer(std::uint64_t seed, SyntheticCast cast = SyntheticCast::One);

  const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  std::size_t shell_triangles() const { return shell_triangles_; }
  std::size_t shell_vertices() const { return shell_vertices_; }
  const std::vector<Eigen::Vector3f>& rest() const { return rest_; }  ///< per vertex: texture coordinate
  int bodies() const { return static_cast<int>(dances_.size()); }
  /// Whether the second is dressed like the first.
  bool alike() const { return cast_ == SyntheticCast::Alike; }
  const Part& part_of_triangle(std::size_t t) const { return parts_[part_of_triangle_[t]]; }

  /// World positions of every vertex at an instant.
  std::vector<Eigen::Vector3f> positions(double seconds) const;

 private:
  void add(const Shell& shell, Part part);
  void add_torso_and_head();
  void add_arm(int side);
  void add_leg(int side);
  void add_strands(std::uint64_t seed);
  SkeletonPose pose(int body, double seconds) const;

  SyntheticCast cast_;
  int adding_ = 0;  // the body whose parts are being added
  std::vector<Choreography> dances_;
  BodyMeasures body_;
  std::vector<Part> parts_;
  std::vector<std::pair<int, Strand>> strands_;  // with their bodies
  std::vector<Eigen::Vector3f> rest_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint16_t> part_of_triangle_;
  std::size_t shell_triangles_ = 0, shell_vertices_ = 0;
};

}  // namespace floatstage::synthetic
