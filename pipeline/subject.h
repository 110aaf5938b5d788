#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "capture/take.h"
#include "core/mesh.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Where the performer is, over all processed frames. Metres, world.
struct Subject {
  Eigen::AlignedBox3d box;
  /// The outermost points of each frame's mesh in directions all around: what a picture must hold to hold
  /// the performer.
  std::vector<Eigen::Vector3d> outermost;
};

/// Extends `subject` by a mesh.
void add(const Mesh& mesh, Subject& subject);

/// Of every mesh that a take has. NotFound when there is none with a subject, and says what to run.
Result<Subject> find_subject(const capture::TakeReader& take);

}  // namespace floatstage::pipeline
