#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/silhouettes/silhouette_turn.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/progress.h"
#include "pipeline/silhouettes/left_out_hulls.h"
#include "pipeline/silhouettes/misplaced_cameras.h"

namespace floatstage::pipeline {

struct SilhouetteCheckOptions {
  double alarm_degrees = 0.1;  ///< smaller turns are nobody's, as in drift's watch
  /// By camera, the turn that was measured when all was well (SilhouetteCameraCheck::before): what outlines
  /// and lenses contribute, which is nobody's drift. Empty: none.
  std::vector<Eigen::Vector3d> reference = {};
  /// Only who has turned: against fewer hulls, by fewer points, and without asking which mattes are wrong
  /// where nobody is. A fifth of the time of 27 cameras; what is corrected may be off by 0.06 degrees.
  bool quick = false;
  int threads = 0;  ///< 0: one per core; the result is the same at any number
  Progress* progress = nullptr;
};

/// One camera against what the others leave.
struct SilhouetteCameraCheck {
  std::string serial;
  calib::SilhouetteTurn before;  ///< in the rig that was given
  calib::SilhouetteTurn after;   ///< in the corrected rig; as `before` where nothing was corrected
  bool named = false;            ///< its pose disagrees with its silhouettes, and a turn explains it
  double turned_degrees = 0;     ///< by how much the corrected rig differs
  int wrong_mattes = 0;          ///< instants whose matte the others contradict, however the camera is turned
};

struct SilhouetteCheck {
  std::vector<SilhouetteCameraCheck> cameras;  ///< as in the rig
  /// Cameras whose pictures are another's, or upside down or mirrored. Not asked quickly.
  std::vector<MisplacedCamera> misplaced;
  Rig corrected;  ///< misplaced cameras where they stand, named ones turned; the others as they were
  /// Some cameras disagree, and no turn of one explains it: that is the calibration as a whole (lenses,
  /// principal points) or the mattes.
  bool whole_rig = false;
  double usual_degrees = 0;  ///< median over the cameras that nobody names, in the corrected rig
  /// Mean IoU of the hull's silhouettes with the mattes; absent where there is no hull.
  std::optional<double> iou_before, iou_after;
};

/// Whether poses and silhouettes agree, from silhouettes alone (calib::measure_silhouette_turn()). Turned and
/// named is the camera after whose turn all others want to turn least: what they then want is at most half of
/// before, and its own turn is larger than the alarm, than five of its standard deviations (without a
/// reference, which errs as it does) and than three times what the others usually want. Up to a quarter of
/// the cameras. Mattes that the hull's audit accuses in the rig that is then found are wrong themselves:
/// their cameras are told, and asked without them.
///
/// Errors: InvalidArgument for fewer than four cameras, another number of mattes than cameras, or of
/// references; NotFound when fewer than four cameras show any subject that the others can bound; Cancelled.
Result<SilhouetteCheck> check_silhouettes(const Rig& rig, const std::vector<InstantMattes>& instants,
                                          const SilhouetteCheckOptions& options);

/// Of a camera that is named: "camera 'x' stands otherwise than its calibration says: …".
std::string sentence(const SilhouetteCameraCheck& named);

/// For people: the cameras that are misplaced, then those that are named, then mattes, then the rig as a
/// whole.
std::vector<std::string> sentences(const SilhouetteCheck& check);

}  // namespace floatstage::pipeline
