#pragma once

#include "calib/solver/scene.h"
#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib::solver {

/// A capture and its scene, everything in it placed where it truly is.
struct TrueScene {
  Rig truth;
  Observations seen;
  Scene scene;
};

/// A board printed on both sides that wanders before a ring of cameras. The first camera holds the world.
TrueScene true_scene(int cameras, const CaptureOptions& options);

/// Largest pixel error of all usable views.
double largest_error(const Scene& scene);

}  // namespace floatstage::calib::solver
