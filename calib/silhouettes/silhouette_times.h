#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "core/silhouette.h"

namespace floatstage::calib {

/// When a camera really takes its pictures, in frame periods: its k-th picture shows the instant at which the
/// reference's picture k + frames would be taken. As CameraQuality::time_offset_ms: an instant is what the
/// stamp says plus this.
struct TimeOffset {
  bool measured = false;
  double frames = 0;         ///< 0 of the reference
  double sigma_frames = 0;   ///< one standard deviation; 0 of the reference
  std::string not_measured;  ///< why, a clause: "nothing moves in its silhouettes"
  /// Median of how far its tangents lie from the others' at every instant alike, px: what no time explains,
  /// but a pose that is off, or hair that one camera sees and another does not. 0 when nothing was compared.
  double apart_px = 0;
};

struct TimeOffsets {
  int reference = -1;               ///< the first camera that could be measured; -1: none
  std::vector<TimeOffset> cameras;  ///< as in the rig
};

struct TimeOffsetOptions {
  /// Only who is apart by some frames: of more than eight cameras not all pairs, and no tips inside of the
  /// outlines. A tenth of the time of 31 cameras.
  bool quick = false;
  int threads = 1;  ///< 0: one per core; the result is the same at any number
};

/// Offsets between cameras that run freely at one rate, from how silhouettes move. The outermost epipolar
/// tangents of a pair of cameras lie in one plane at any one instant; of a pair that is
/// apart in time, each follows the other by that time. `frames[k][i]`: camera i's k-th picture of a take,
/// none left out; an outline without points says nothing. Outlines as they are, hair and fingers with them:
/// what an opening takes away differs from camera to camera by more. Then tips inside of the outlines (hands,
/// knees) that the first offsets tell to be one. Take a second and a half of motion or more (45 frames): one
/// leaves errors of up to a tenth of a frame (and says so in sigma). Only motion counts; a camera whose
/// tangents lie farther from the others' at all times than theirs do from one another has a pose that is off,
/// which pretends offsets: it is not measured, and says why. Offsets of up to two frames, and beyond them by
/// whole_frames_apart(), where that tells them clearly. InvalidArgument
/// when there are fewer than two cameras or twelve frames.
Result<TimeOffsets> measure_time_offsets(const Rig& rig, std::span<const std::vector<Silhouette>> frames,
                                         const TimeOffsetOptions& options = {});

}  // namespace floatstage::calib
