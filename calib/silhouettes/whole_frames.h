#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace floatstage::calib {

/// Where a tangent that two cameras have in common lies in either's pictures, frame by frame, in pixels; NaN:
/// not seen.
struct SharedTangent {
  int a = 0, b = 0;  ///< cameras
  std::span<const double> in_a, in_b;
};

/// By how many whole frames each camera is apart from most others, up to kMostWholeFrames, as
/// TimeOffset::frames: 0 for one that is apart by less than two frames, or where tangents do not tell it
/// clearly: brought to the others' time, its tangents lie half as far from theirs as before. Cameras are
/// named one after the other, the clearest first.
std::vector<int> whole_frames_apart(std::size_t cameras, std::span<const SharedTangent> tangents);

inline constexpr int kMostWholeFrames = 12;  ///< half a second at 25 a second: what starting by hand leaves

}  // namespace floatstage::calib
