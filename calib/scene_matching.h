#pragma once

#include <span>
#include <vector>

#include "calib/markerless.h"
#include "calib/scene_keypoints.h"
#include "core/rig.h"

namespace floatstage::calib {

/// Keypoints of two pictures that look alike. Private to calib.
struct SceneMatches {
  struct Match {
    int i = 0, k = 0;  ///< keypoints of picture a and of b
    int likeness = 0;  ///< scalar product of their descriptors: 512² when equal
  };
  int a = 0, b = 0;  ///< pictures, a < b
  std::vector<Match> matches;
};

/// Every pair of pictures: keypoints that are each other's most alike, by a margin. Nothing is left to
/// chance: all are compared. Of more than 32 pictures, each with the 16 that share most of their largest
/// keypoints, and with those whose 16 it is among.
std::vector<SceneMatches> match_pictures(std::span<const SceneKeypoints> pictures, int threads);

/// The same among keypoints that can show one point given where cameras are: within `tolerance` px of each
/// other's epipolar line. Camera i of the rig took picture i. Of more than 32 pictures, each with those of
/// the 16 cameras nearest by that look its way, and with those that it is near to.
std::vector<SceneMatches> match_along_lines(std::span<const SceneKeypoints> pictures, const Rig& rig,
                                            double tolerance, int threads);

/// Points that three cameras or more see within `tolerance` px of where their rays meet. Matches are joined
/// from the most alike to the least; two keypoints of one picture are never one point.
std::vector<SceneFeature> points_of_matches(std::span<const SceneKeypoints> pictures,
                                            std::span<const SceneMatches> matches, const Rig& rig,
                                            double tolerance);

}  // namespace floatstage::calib
