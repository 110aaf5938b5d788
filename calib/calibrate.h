#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "core/measured.h"
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
  /// One sigma of how far the cameras are from a common circle (a turntable's ring), as a share of its
  /// radius: a soft prior for places that little else ties. Four cameras at least; sigmas of the result make
  /// no use of it. 0: nothing is known. 1e-5 … 0.3.
  double ring = 0;
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

/// How one camera did, and how well its numbers are known (one standard deviation). What nobody measured says
/// why and is never 0.
struct CameraQuality {
  std::string serial;
  int views = 0, points = 0, outliers = 0;
  Measured rms_px;        ///< of the pixel errors' lengths, inliers
  Measured p95_px;        ///< 95th percentile of the lengths, outliers too
  Measured holdout_px;    ///< RMS in frames that had no part in the solution that predicts them
  Measured depth_ratio;   ///< farthest over nearest board point
  Measured tilt_degrees;  ///< of two board views or more
  double covered = 0;     ///< share of the picture's 8×6 cells in which a point was seen
  /// fx fy cx cy (px), then the lens' coefficients (8 places), then the skew (px); 0 for those that were not
  /// solved for.
  Eigen::Matrix<double, 13, 1> intrinsics_sigma = Eigen::Matrix<double, 13, 1>::Zero();
  /// Relative to the reference camera, whose own are not measured.
  Measured rotation_sigma_degrees, position_sigma_mm;
  Measured time_offset_ms, time_offset_sigma_ms;
  std::optional<double> moved_mm, turned_degrees;  ///< since the pose it started from (Prior::Start)
};

/// Lengths that are known, as the cameras alone measure them: every point from its rays, without its board's
/// shape.
struct LengthQuality {
  std::string target;
  int count = 0;
  double rms_mm = 0, bias_mm = 0;     ///< measured minus known; worth nothing where `count` is 0
  double ratio = 1, ratio_sigma = 0;  ///< measured over known, all lengths together
  /// One of the numbers above as a figure of a report.
  Measured figure(double number) const {
    return Measured::of(number, count, "no known length was seen by two cameras at a good angle");
  }
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

/// Rows of Calibration::covariance a camera: 13 intrinsics, a rotation vector on the left of cam_from_world
/// (rad), its translation (m).
inline constexpr int kCovarianceRows = 19;

struct Calibration {
  Rig rig;
  int reference =
      -1;  ///< the camera in whose frame sigmas are; -1: fixed poses or surveyed markers held the world
  std::vector<CameraQuality> cameras;
  std::vector<LengthQuality> lengths;  ///< a row a target that was measured
  LengthQuality scale;                 ///< all of them
  Measured jitter_ms;  ///< how far pictures stray from their instants (sigma), of time offsets' solution
  std::vector<CameraLink> links;
  std::vector<NamedFailure> failures;
  std::vector<std::string> remarks;
  std::vector<TargetPlace> places;  ///< of boards
  std::vector<PointError> errors;
  Eigen::MatrixXd covariance;  ///< kCovarianceRows a camera
  /// One a camera, 1 or more: how much further than its points' noise alone the solution moves when frames
  /// are left out; all sigmas are larger by it (ADR 0224).
  std::vector<Measured> scatter;
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
