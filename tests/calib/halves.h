#pragma once

#include <cstdint>

#include "calib/calibrate.h"

namespace floatstage::calib {

/// How far two solutions from disjoint halves of a capture's frames are apart, over how far their stated
/// sigmas say: 1 where the sigmas are honest. Of pixels all over the targets' volume, in all cameras, after
/// the motion of the whole rig that no picture shows is taken out; RMS over `splits` random splits. Frames
/// are dealt out in `blocks` runs of neighbours, whose errors are alike.
struct HalvesRatio {
  double ratio = 0;
  int splits = 0;        ///< those whose halves could both be solved
  double apart_px = 0;   ///< RMS of a coordinate's difference
  double stated_px = 0;  ///< what the sigmas say of it
};
HalvesRatio halves_ratio(const Observations& all, int splits, int blocks, std::uint64_t seed,
                         bool time_offsets = false);

/// The views of some frames only.
Observations only_frames(const Observations& all, const std::vector<int>& frames);
/// One camera's views only.
Observations only_camera(const Observations& all, int camera);
std::vector<int> frames_of(const Observations& all);

}  // namespace floatstage::calib
