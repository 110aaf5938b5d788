#pragma once

#include <vector>

#include "recon/visual_hull.h"

namespace floatstage::recon {

/// What a hull of silhouettes explains of them. `iou`, `hull.silhouette_iou`: of each camera the hull's
/// silhouette against its matte; NaN for one that has none.

/// Whether the hull explains less than nine tenths of half of the silhouettes (four cameras at least): then
/// some mattes lack what the others see, in pieces too small for the audit's blocks, or the calibration is
/// off.
bool poorly_covered(const std::vector<double>& iou);

/// Share of a matte that thick pieces may have which the hull denies (denied_pieces()), by how many cameras
/// have mattes: what a key takes along is denied by the more, the more they are.
double most_in_pieces(int cameras);

/// Whether mattes may hold what contradiction_in() asks for: the hull leaves more than most_in_pieces() of at
/// least half of the silhouettes open, clean-up aside. `hull` was made with its quality.
bool may_contradict(const HullReport& hull);

/// Whether the hull leaves more than a twentieth of at least half of the silhouettes open, clean-up aside:
/// then mattes contradict one another, or the calibration is off. `hull` was made with its quality.
bool leaves_much_open(const HullReport& hull);

}  // namespace floatstage::recon
