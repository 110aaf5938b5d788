#pragma once

#include <optional>

#include "calib/solver/scene.h"

namespace floatstage::calib::solver {

/// Where camera b stands seen from a, by the wand markers that both saw: the essential matrix of all of them
/// (eight points, weighted again by its own residuals), its scale from the wand's lengths. Both cameras need
/// intrinsics. Absent with fewer than kFewestWandPoints or when no length was seen whole.
std::optional<Rigid3> pose_from_wand(const Scene& scene, int a, int b);

inline constexpr int kFewestWandPoints = 20;

/// Markers that moved and were seen by both at once, and in how many frames.
struct WandOverlap {
  int frames = 0, points = 0;
};
WandOverlap wand_overlap(const Scene& scene, int a, int b);

}  // namespace floatstage::calib::solver
