#pragma once

#include <vector>

#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// What a hull of silhouettes explains of them. `iou`, `hull.silhouette_iou`: of each camera the hull's
/// silhouette against its matte; NaN for one that has none.

/// Whether the hull explains less than nine tenths of half of the silhouettes (four cameras at least): then
/// some mattes lack what the others see, in pieces too small for the audit's blocks, or the calibration is
/// off.
bool poorly_covered(const std::vector<double>& iou);

/// Whether the hull leaves more than a twentieth of at least half of the silhouettes open, clean-up aside:
/// then mattes contradict one another, or the calibration is off. `hull` was made with its quality.
bool leaves_much_open(const recon::HullReport& hull);

}  // namespace floatstage::pipeline
