#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/board.h"
#include "calib/calibrate.h"
#include "calib/markerless.h"
#include "calib/rig_formats.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// What a calibration must reach to pass.
struct CalibrationBars {
  double rms_px = 0.5;                  ///< of every camera
  double p95_px = 1.5;                  ///< 95th percentile of every camera, outliers too
  double holdout_ratio = 1.3;           ///< error in held-out frames over the RMS, every camera
  double scale_rms_mm = 2;              ///< of known lengths, measured by the cameras alone
  double scale_bias_mm = 0.5;           ///< their mean error
  double focal_sigma_percent = 0.5;     ///< of every camera that was solved for
  double rotation_sigma_degrees = 0.1;  ///< of every camera against the reference camera
  double points_px = 5;                 ///< how near rays through the session's points come, where it has any
  double projection_sigma_px = 0.5;     ///< RMS over the working volume, every camera; the choice of a
                                        ///< reference changes nothing
  std::optional<double> known_center_percent =
      {};  ///< of known places that are compared with, after a similarity; of the rig's radius
};

struct SessionCamera {
  std::string
      serial;  ///< empty while paths have the word {serial} (session_patterns.h): in no loaded session
  calib::LensKind lens = calib::LensKind::BrownConrady;
  calib::LensTerms terms;
  /// Pictures of the same instants in every camera: one video, or a folder or list of stills in their order.
  std::filesystem::path video;
  std::vector<std::filesystem::path> images;
  /// Pictures of the target that this camera took alone, for its intrinsics.
  std::vector<std::filesystem::path> alone;
  /// A picture of the scene without a target, for markerless calibration; several of a camera that was
  /// carried about.
  std::vector<std::filesystem::path> scene;
  bool carried = false;  ///< it is not of the rig: its pictures tie the others together
};

/// What is known beforehand, from a calibration of any format of calib/rig_formats.h.
struct SessionKnown {
  std::string format = std::string(calib::kAnyRigFormat);
  std::filesystem::path file;
  double metres_per_unit = calib::kMetresPerUnit;  ///< of formats that state no unit
  calib::Prior intrinsics = calib::Prior::Unknown,
               poses = calib::Prior::Unknown;  ///< Unknown: only compared with
};

/// A point of the scene as several cameras see it, found by hand: not solved with, but what the result is
/// checked by.
struct SessionPoint {
  struct Seen {
    std::string serial;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (0, 0) is the picture's corner
  };
  std::string name;
  std::vector<Seen> seen;  ///< by two cameras or more
};

/// The world: a frame in which the target lies on the floor, or the known pose of one camera.
struct SessionFloor {
  int frame = 0;
  double height = 0;  ///< metres of the printed face above the floor
};

/// Which lenses a markerless session solves for, of cameras whose lens is not known.
enum class UnknownLenses {
  Refused,   ///< there should be none
  Shared,    ///< all have one: one camera that was carried about, or a turntable's, or cameras alike
  Separate,  ///< each its own
};

/// Cameras placed by what they see of the scene, without a target.
struct SessionMarkerless {
  std::string a, b;  ///< two cameras whose distance is known; empty: a target or a known rig gives the scale
  double distance = 0;                      ///< metres between their centres
  double sigma = 1e-3;                      ///< metres
  double timeout = 3600;                    ///< seconds, for each of COLMAP's steps
  double least_track = 3.5;                 ///< pictures that show a point, on average
  int least_points = 60;                    ///< points that a picture shows
  double contrast = calib::kUsualContrast;  ///< of the faintest keypoints
  UnknownLenses lens = UnknownLenses::Refused;
  double focal_px = 0;                ///< nearly, of unknown lenses; 0: what EXIF says, or nothing
  double largest_focal_error = 0.02;  ///< share by which points may contradict a known focal length
  double ring = 0;  ///< the cameras stand on a circle within this share of its radius; 0: nobody says so
};

/// Where the calibration must hold: a box of the world, metres.
struct SessionVolume {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();
};

/// A calibration session as people write it: which pictures are of which camera, what they show, what is
/// known. Paths are relative to the session's file.
struct Session {
  std::optional<calib::TargetDesign> target;
  double wand_sigma = 1e-4;            ///< metres, of a wand's lengths
  std::filesystem::path observations;  ///< instead of cameras and target: what was detected before
  std::vector<SessionCamera> cameras;
  double frame_rate = 0;           ///< of the videos; 0: as they say
  int first_frame = 0, every = 1;  ///< which pictures are looked at
  std::optional<int> end_frame;    ///< not included
  std::optional<SessionKnown> known;
  std::optional<SessionFloor> floor;
  std::optional<SessionMarkerless> markerless;
  std::optional<SessionVolume> volume;  ///< absent: the convex hull of all targets
  std::vector<SessionPoint> points;
  calib::CalibrationOptions options;
  CalibrationBars bars;
};

/// Reads TOML strictly: an unknown key is an error. BadData names the file, the line and what is wrong.
/// docs/calibrating.md has the keys.
Result<Session> parse_session(std::string_view toml, std::string_view name_for_errors);
/// The same from a file, its paths made relative to where the program runs.
Result<Session> load_session(const std::filesystem::path& file);

}  // namespace floatstage::pipeline
