#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

struct CalibrationOptions {
  bool time_offsets = false;  ///< solve for when each camera exposes, from how targets move; needs times and
                              ///< consecutive frames
  int holdout_every = 5;  ///< each fifth frame is kept from a solution and predicted by it, in small captures
                          ///< all in turn; 0: none
  double outlier_sigmas = 4.5;  ///< a point further off than this many of its camera's sigmas is left out
  int threads = 0;              ///< 0: one a core; the result is the same
  /// Bars: what the named failures are measured against.
  double least_depth_ratio =
      1.2;  ///< farthest over nearest board point (95th over 5th percentile) of a camera
  double least_tilt_degrees = 6;  ///< how far a camera's board views must turn from their mean direction
  double largest_length_error = 0.005;  ///< of a known length, as a share of it
  double late_frames = 0.5;             ///< a camera later than this is named
};

/// What can be wrong with a capture so that a small reprojection error says nothing.
enum class CalibrationFailure {
  ConstantDepth,  ///< a camera saw the board at one distance only: focal length and distance are confounded
  PlanarMotion,   ///< all board views of a camera are parallel: its focal length is not determined
  SwappedRowsColumns,  ///< the board has as many columns as it was said to have rows
  WrongSquareSize,     ///< known lengths come out longer or shorter
  MirroredBoard,       ///< the board is seen from behind: the print or its description is mirrored
  LateCamera,          ///< one camera's pictures belong to another instant
};
/// "constant-depth", "planar-motion", …: stable, for JSON.
const char* name_of(CalibrationFailure failure);

struct NamedFailure {
  CalibrationFailure kind;
  std::string camera;    ///< serial; empty when it is about a target
  std::string sentence;  ///< what was found, in numbers, and what to do
};

/// How one camera did, and how well its numbers are known (one standard deviation).
struct CameraQuality {
  std::string serial;
  int views = 0, points = 0, outliers = 0;
  double rms_px = 0;  ///< of the pixel errors' lengths, inliers
  double p95_px = 0;  ///< 95th percentile of the lengths, outliers too
  double holdout_px =
      0;  ///< RMS in frames that had no part in the solution that predicts them; 0 when none were held out
  double depth_ratio = 0;  ///< 0: saw no board
  double tilt_degrees = 0;
  double covered = 0;  ///< share of the picture's 8×6 cells in which a point was seen
  /// fx fy cx cy (px), then the lens' coefficients; 0 for those that were not solved for.
  Eigen::Matrix<double, 9, 1> intrinsics_sigma = Eigen::Matrix<double, 9, 1>::Zero();
  /// Relative to the reference camera, whose own are 0.
  double rotation_sigma_degrees = 0, position_sigma_mm = 0;
  double time_offset_ms = 0, time_offset_sigma_ms = 0;
  std::optional<double> moved_mm, turned_degrees;  ///< since the pose it started from (Prior::Start)
};

/// Lengths that are known, as the cameras alone measure them: every point from its rays, without its board's
/// shape.
struct LengthQuality {
  std::string target;
  int count = 0;
  double rms_mm = 0, bias_mm = 0;     ///< measured minus known
  double ratio = 1, ratio_sigma = 0;  ///< measured over known, all lengths together
};

struct CameraLink {
  int a = 0, b = 0;            ///< indices into the rig's cameras
  int frames = 0, points = 0;  ///< seen by both at once
  bool in_tree = false;        ///< the start went along it
};

struct PointError {
  int camera = 0, frame = 0, id = 0, target = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero(), error = Eigen::Vector2d::Zero();  ///< projected minus seen
  double depth = 0;                                                                  ///< metres
  bool kept = true;
};

struct TargetPlace {
  int target = 0, frame = 0;
  Rigid3 world_from_target;
};

/// Rows of Calibration::covariance a camera: 9 intrinsics, a rotation vector on the left of cam_from_world
/// (rad), its translation (m).
inline constexpr int kCovarianceRows = 15;

struct Calibration {
  Rig rig;
  int reference =
      -1;  ///< the camera in whose frame sigmas are; -1: fixed poses or surveyed markers held the world
  std::vector<CameraQuality> cameras;
  std::vector<LengthQuality> lengths;  ///< a row a target that was measured
  LengthQuality scale;                 ///< all of them
  double jitter_ms =
      0;  ///< how far pictures stray from their instants (sigma); 0 unless time offsets are solved for
  std::vector<CameraLink> links;
  std::vector<NamedFailure> failures;
  std::vector<std::string> remarks;
  std::vector<TargetPlace> places;  ///< of boards
  std::vector<PointError> errors;
  Eigen::MatrixXd covariance;  ///< kCovarianceRows a camera
  double seconds = 0;
};

/// Intrinsics, poses, boards, markers and lengths solved for together. The start is found directly (no chance
/// is involved), outliers are left out in stages, and the gauge is what `observations.gauge` says. What makes
/// the numbers worthless although they look well is named in `failures`; that they are worth something is for
/// the caller's bars. BadData when there is nothing to solve or no chain of targets joins the cameras, naming
/// them.
Result<Calibration> calibrate(const Observations& observations, const CalibrationOptions& options = {});

/// Standard deviation (px, root of the covariance's mean eigenvalue) of where camera `camera` sees a world
/// point, due to the calibration's own uncertainty. Relative to the rig as a whole: a common motion of all
/// cameras, which no picture can show, is taken out where it changes the projections of `volume` least.
/// Infinite behind the camera.
class ProjectionUncertainty {
 public:
  ProjectionUncertainty(const Calibration& calibration, const std::vector<Eigen::Vector3d>& volume);
  double sigma_px(int camera, const Eigen::Vector3d& in_world) const;

 private:
  const Rig rig_;
  Eigen::MatrixXd covariance_;
};

}  // namespace floatstage::calib
