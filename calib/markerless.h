#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/observations.h"
#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::calib {

/// A picture and the camera that took it. Of the file's pixels every step but COLMAP's makes use.
struct MarkerlessPicture {
  std::string serial;
  std::filesystem::path file;
  CameraModel model;
  Image pixels;  ///< 1 or 3 channels
  /// Fixed: the model holds. Start: it is nearly that. Unknown: of the model only the size and whether it has
  /// a lens count. What is not fixed is solved for as a plain lens (CalibrationCamera::plain_lens).
  Prior lens = Prior::Fixed;
  /// Index of an earlier picture with a lens of its own, not fixed, which is this one's too.
  std::optional<int> same_lens_as = {};
};

/// MarkerlessOptions::contrast where nothing asks for less.
inline constexpr double kUsualContrast = 0.012;

struct MarkerlessOptions {
  std::string program = "colmap";  ///< COLMAP 3.8's command line program
  double timeout = 3600;           ///< seconds, for each of its steps: only what hangs takes that long
  int threads = 0;                 ///< 0: one a core
  std::function<bool()> cancelled = nullptr;  ///< asked while COLMAP works, on any thread
  /// Of the faintest keypoints that count, of 1, as Lowe counts it: less finds more on bare surfaces, and
  /// also noise (contrast_for()).
  double contrast = kUsualContrast;
  /// Bars below which the result is refused: its reprojection error would look fine all the same.
  double least_track = 3.5;  ///< pictures that show a point, on average (ADR 0252)
  int least_points = 60;     ///< points that a picture shows
  /// A given focal length that the points contradict by more than this share (and five sigmas) is refused.
  double largest_focal_error = 0.02;
  /// The cameras stand on a circle, a turntable's ring, within this share of its radius (one sigma): holds
  /// places that few points tie. Refused where the points say otherwise. 0: nothing is known.
  double ring = 0;
};

/// A point of the scene and where it was seen.
struct SceneFeature {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<std::pair<int, Eigen::Vector2d>>
      seen;  ///< index of the picture, px (corner origin); three or more
};

struct MarkerlessResult {
  Rig rig;      ///< in the order of the pictures, with their lenses; the unit is arbitrary, see scale_to()
  Rig settled;  ///< where the cameras are by these points alone, in a world of their own; equals `rig` unless
                ///< that was known
  std::vector<SceneFeature> features;  ///< in the settled rig's world and unit
  double mean_track = 0;               ///< pictures a point
  double rms_px = 0;                   ///< reprojection error of the points: says little
  std::optional<double> off_ring;      ///< rms distance of the cameras from their circle, as a share of its
                                       ///< radius; where a ring was asked for
};

/// What contrast lets these pictures of a scene show enough: the usual one, or a quarter of it where the
/// median picture has fewer than 700 keypoints (plaster, plain cloth).
double contrast_for(std::span<const Image> pictures, int threads);

/// Poses of cameras that saw one scene, without a target. COLMAP (a subprocess that needs no display) places
/// them; its estimates are drawn by chance and differ from run to run, so they are only a start: keypoints
/// are matched again along the lines that poses allow, and poses and points are solved for together, three
/// times. Lenses that are not fixed are solved for with them. `workspace` is a new or empty folder; database,
/// models and `colmap.log` stay there. Errors: NotFound when COLMAP is not installed or a picture is missing;
/// AlreadyExists for a workspace that holds something; Timeout; Cancelled; BadData when it finds no model,
/// leaves cameras out or ties them too loosely, naming them and what helps, and when the points contradict a
/// given focal length; Io.
Result<MarkerlessResult> calibrate_markerless(const std::vector<MarkerlessPicture>& pictures,
                                              const std::filesystem::path& workspace,
                                              const MarkerlessOptions& options = {});

/// The same where poses are known already: points are found from them, and `rig` stays as it is known; COLMAP
/// is not needed. NotFound when `known` lacks a camera; BadData also when a camera sees too few points where
/// it is said to be: it has moved.
Result<MarkerlessResult> triangulate_markerless(const std::vector<MarkerlessPicture>& pictures,
                                                const Rig& known, const MarkerlessOptions& options = {});

/// The rig enlarged about its origin so that two cameras are that far apart. NotFound for a serial that is
/// not there, InvalidArgument for a distance that is not positive or two cameras in one place.
Result<Rig> scale_to(Rig rig, const std::string& serial_a, const std::string& serial_b, double metres);

}  // namespace floatstage::calib
