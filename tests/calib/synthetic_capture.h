#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/observations.h"
#include "core/random.h"
#include "core/rig.h"

namespace floatstage::calib {

/// Captures of targets whose truth is known to the last digit: what detectors would have given, with noise
/// and outliers.

/// `columns`×`rows` points, `pitch` metres apart, printed on one side.
Target grid_board(int columns, int rows, double pitch);
/// The same on both sides of a plate `thickness` metres thick; the back's ids begin at 1000.
Target two_sided_board(int columns, int rows, double pitch, double thickness);
/// Markers 0 … n-1 on a line at these places (metres from the first).
Target wand(const std::vector<double>& places, double sigma);

Rig ring_rig(int cameras, double radius = 3, double height = 1.4);
/// Two groups of four that look at each other across the stage, none of a group with one of the other in its
/// half.
Rig facing_rig();
/// Three wide fisheyes near by, one long lens far away.
Rig mixed_rig();
/// Cameras over a half sphere.
Rig dome_rig(int cameras);

struct CaptureOptions {
  int frames = 100;
  double noise_px = 0.1, outliers = 0.02;  ///< outliers: 5 to 60 px off
  double steepest_degrees = 65;            ///< beyond this slant a detector finds nothing
  std::uint64_t seed = 1;
  Eigen::Vector3d center{0, 0, 1};
  double extent = 0.6;  ///< half the side of the cube in which the board's centre is
  double frame_seconds = 1.0 / 30;
  int late_camera = -1;
  double late_frames = 1;     ///< that camera's pictures show what the others saw so many frames before
  double jitter_seconds = 0;  ///< sigma of each picture's own instant
};

/// Where a target is at a time (s); smooth, so that neighbouring frames are near each other.
using Path = std::function<Rigid3(double)>;
/// Through all of the volume, turning to all sides.
Path wandering(const CaptureOptions& options, double speed = 1);

/// What the rig sees of `target` (boards and wands) along `path`: every point that faces the camera and lies
/// in its picture, of views with at least 6 points of a board.
Observations capture(const Rig& truth, const Target& target, const Path& path, const CaptureOptions& options);
/// Adds views of another target, in frames of their own.
void capture_more(Observations& seen, const Rig& truth, const Target& target, const Path& path,
                  const CaptureOptions& options);

struct TruthErrors {
  double focal = 0;             ///< largest, as a share
  double rotation_degrees = 0;  ///< largest, after the alignment
  double grid_mm = 0;           ///< mean over 1,000 points that no board marked, after the alignment
};
/// Unseen points in the volume, projected by the truth, intersected by the solved rig, moved rigidly (never
/// scaled) onto the truth.
TruthErrors compare(const Rig& solved, const Rig& truth, const CaptureOptions& options);

}  // namespace floatstage::calib
