#pragma once

#include <span>
#include <vector>

#include "calib/markerless.h"
#include "calib/scene_keypoints.h"
#include "core/result.h"

namespace floatstage::calib {

/// Which lenses a settling solves for. Private to calib, as all of this file.
enum class Lenses {
  AsGiven,  ///< those of pictures whose lens is not fixed
  AllFree,  ///< all: what tells that a given one is wrong
};

/// Points that keypoints show given result.rig, into result.features, with what can be said of them.
void add_points(std::span<const SceneKeypoints> keypoints, double tolerance, int threads,
                MarkerlessResult& result);

/// From poses (and lenses) that are roughly right to ones that agree with points matched again along the
/// lines of sight. BadData names the camera that shows too few points, with `advice`; Cancelled.
Result<void> settle(const std::vector<MarkerlessPicture>& pictures, std::span<const SceneKeypoints> keypoints,
                    const MarkerlessOptions& options, const char* advice, MarkerlessResult& result);

/// Whether the settled cameras stand on a ring as options.ring says, and how far off they are, into
/// result.off_ring; at once where nobody says so. BadData names the camera that is farthest off.
Result<void> check_ring(const std::vector<MarkerlessPicture>& pictures, const MarkerlessOptions& options,
                        MarkerlessResult& result);

/// A lens as the scene's points have it beside what was given.
struct SuspectLens {
  std::size_t picture = 0;      ///< the first of those that have it
  double given = 0, found = 0;  ///< focal lengths, px
  double sigma = 0;             ///< of what was found
  double share() const { return found / given - 1; }
};

/// Given lenses whose focal length the points of a settled result contradict: more than `least` off (as a
/// share) and five sigmas.
Result<std::vector<SuspectLens>> suspect_lenses(const std::vector<MarkerlessPicture>& pictures,
                                                const MarkerlessResult& settled, double least, int threads);

/// The sentence for it: what was given, what fits, what to do.
std::string describe(const SuspectLens& suspect, const std::vector<MarkerlessPicture>& pictures);

}  // namespace floatstage::calib
