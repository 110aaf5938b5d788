#pragma once

#include <optional>
#include <string>

#include "core/rig.h"
#include "pipeline/camera_path.h"
#include "pipeline/subject.h"

namespace floatstage::pipeline {

/// A walk around the stage; what is absent is as the cameras have it.
struct OrbitOptions {
  double seconds = 6;
  std::optional<double> height = {};    ///< metres above the subject's middle, along the ring's axis
  std::optional<double> distance = {};  ///< metres from the middle of the circle, level
  std::optional<double> fov = {};       ///< vertical, degrees; absent: so much that the subject fits
  double turns = 1;                     ///< times around, or there and back; negative goes the other way
  double start = 0;                     ///< degrees from where the cameras begin
  double aspect = 4.0 / 3;              ///< width by height of the pictures that the subject shall fit into
};

struct Orbit {
  CameraPath path;
  Eigen::Vector3d axis;             ///< what is up in every picture
  double height = 0, distance = 0;  ///< as in OrbitOptions
  double fov = 0;                   ///< degrees
  double covered = 0;               ///< degrees that the walk goes through: 360, or the cameras' arc
};

/// Around `subject` where the rig's cameras stand (pipeline/ring.h): on their circle, at their usual
/// elevation and distance, aimed so that the subject's silhouettes lie in the middle and a tenth of the
/// picture stays free beside them. A full turn when the cameras surround the subject, else from one end of
/// their arc to the other and back (no camera has seen the rest). A subject that nobody knows yet (live) is
/// taken to be where the cameras look, and their mean field of view is the orbit's.
Orbit orbit_around(const Rig& rig, const Subject& subject, const OrbitOptions& options);

/// "around (0, 1, 0), 0.55 m from it, …": what an orbit came to.
std::string describe(const Orbit& orbit);

}  // namespace floatstage::pipeline
