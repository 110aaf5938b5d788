#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "capture/take.h"
#include "core/mesh.h"
#include "core/result.h"
#include "pipeline/camera_path.h"

namespace floatstage::pipeline {

/// Where the performer is, over all processed frames. Metres, world.
struct Subject {
  Eigen::AlignedBox3d box;
  /// The outermost points of each frame's mesh in directions all around: what a picture must hold to hold
  /// the performer.
  std::vector<Eigen::Vector3d> outermost;
  /// Of find_subject(): the middle of each frame's hull (of its volume), between its neighbours' where there
  /// is none, smoothed over half a second.
  SubjectTrack track = {};
};

/// Extends `subject` by a mesh.
void add(const Mesh& mesh, Subject& subject);

/// The track of a take whose hulls have these middles, absent where there is none; one is there at least.
SubjectTrack smoothed_track(const std::vector<std::optional<Eigen::Vector3d>>& middles, double frame_rate);

/// Of every mesh that a take has. NotFound when there is none with a subject, and says what to run.
Result<Subject> find_subject(const capture::TakeReader& take);

}  // namespace floatstage::pipeline
