#pragma once

#include <array>
#include <string>
#include <vector>

#include "calib/observations.h"

namespace floatstage::calib {

/// What a capture of a target shows so far, and what it still lacks: for the operator who is waving it. Needs
/// no solution.

inline constexpr int kCoverageColumns = 8, kCoverageRows = 6;

/// How one camera saw the target.
struct CameraCoverage {
  std::string serial;
  int views = 0;
  std::array<int, kCoverageColumns * kCoverageRows>
      cells{};                       ///< points seen in each cell of the picture, by rows
  double covered = 0;                ///< share of the cells with a point
  double nearest = 0, farthest = 0;  ///< largest and smallest size of the target in the picture, px a metre;
                                     ///< 0: never seen, or a wand
  double fills = 0;  ///< the largest share of the picture's width that the board's diagonal took
  /// Views in which the board (not a wand) faced the camera, was turned about its upright, and leaned about
  /// its level axis, by more than kTilted degrees.
  int facing = 0, turned = 0, leaned = 0;
  double depth_ratio() const { return farthest > 0 ? nearest / farthest : 0; }
};
inline constexpr double kTilted = 20;  // degrees

struct Coverage {
  std::vector<CameraCoverage> cameras;
  std::vector<std::vector<int>> common;  ///< [a][b]: frames in which both saw the target
  std::vector<int> group;  ///< a number a camera: those of one number are joined by common views
};

Coverage coverage_of(const Observations& observations);

/// What is enough.
struct CoverageGoals {
  int views = 15;            ///< of every camera
  int common = 8;            ///< frames that join two cameras
  double covered = 0.6;      ///< of a camera's cells
  double depth_ratio = 1.6;  ///< farthest over nearest
  int tilted = 4;            ///< views turned, and views leaned
};

enum class AdviceKind { NeverSeen, NoCommonView, WeakLink, FewViews, Region, Nearer, Farther, Turn, Lean };

/// What to show next. The most needed comes first; empty: enough.
struct Advice {
  AdviceKind kind = AdviceKind::NeverSeen;
  std::string camera, other;  ///< serials; `other` of links only
  std::string sentence;
};
std::vector<Advice> advise(const Coverage& coverage, const CoverageGoals& goals = {});

/// From 0 to 1: the share of all goals that is reached. It never falls while views are added.
double completeness(const Coverage& coverage, const CoverageGoals& goals = {});

}  // namespace floatstage::calib
