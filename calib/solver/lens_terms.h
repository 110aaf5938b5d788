#pragma once

#include "calib/calibrate.h"
#include "calib/solver/bundle.h"
#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Which terms of its lens each camera keeps, as the capture shows them. All of these change the scene and
/// return whether any camera's lens is another than before: it is to be solved again then.

/// k3 of lenses that fold over inside their picture; a denominator is left to be settled first.
bool drop_folding_terms(Scene& scene);

/// k3 of cameras that left it to the capture, where it is nearer to 0 than three sigmas.
bool drop_unshown_third(Scene& scene, const BundleOptions& solved);

/// Denominators that were asked for begin to be solved for: to be called where all other terms have settled.
bool admit_denominators(Scene& scene);

/// Denominators, each as a whole, that are nearer to 0 than chance takes them (three sigmas): those cameras
/// get back the lens that they had before. One with which the lens folds over inside its picture loses a
/// term. To be repeated until nothing changes: at most three times.
bool drop_unshown_denominators(Scene& scene, const BundleOptions& solved);

}  // namespace floatstage::calib::solver
