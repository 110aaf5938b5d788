#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "detail/features.h"
#include "detail/nearest_descriptors.h"

namespace floatstage::detail {

/// What one photograph is to another: whether it shows a part of it, and where.
struct PairRelation {
  int matches = 0;  ///< features that found each other, one to one
  int inliers = 0;  ///< those that the homography explains in the end; 0 where there is none
  /// From the child's pixels to the parent's, corners at whole numbers. Zero where none was found.
  Eigen::Matrix3d parent_from_child = Eigen::Matrix3d::Zero();
  double zoom = 0;    ///< linear: pixels of the child in one of the parent; 0 without a homography
  double inside = 0;  ///< how much of the child lies in the parent
  double rms = 0;     ///< of the inliers, px of the parent
  std::string why;    ///< why it is no detail of it, a sentence's end; empty: it is contained

  bool contained() const { return why.empty(); }
};

/// Relates a child to what may be its parent (thesis 4.2.1): features whose nearest neighbour is nearer than
/// 0.49 times the second, one to one; at least 10 of them on one homography (RANSAC, 3 px of the shrunk
/// parent); then matched again where the homography says, at 0.8, and fitted to all (the strict ratio starves
/// the fit at high zooms: notes in docs/detail.md). `nearest`: of each of the child's features among the
/// parent's. Deterministic; not threaded.
PairRelation relate(const PhotoFeatures& child, const PhotoFeatures& parent,
                    const std::vector<Nearest>& nearest);

}  // namespace floatstage::detail
