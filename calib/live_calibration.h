#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/board.h"
#include "calib/calibrate.h"
#include "calib/coverage.h"
#include "calib/detect.h"
#include "core/frame.h"

namespace floatstage::calib {

/// What is fixed before the first picture.
struct LiveTarget {
  TargetDesign design;
  double wand_sigma = 1e-4;  ///< metres, of a wand's lengths
  LensKind lens = LensKind::BrownConrady;
  /// A set counts only when the target has moved since the last one that counted, in some camera by so much
  /// of its picture's width: a board that is held still says nothing new. 0: every set counts.
  double least_move = 0.01;
  int threads = 0;
};

/// One instant as the view shows it.
struct LiveInstant {
  Timestamp time;
  std::vector<Detection>
      detections;  ///< one a camera; of cameras that missed the instant: empty with a reason
  bool counted = false;
};

/// The calibration of a running capture: sets of pictures in, coverage, advice and a solution out. The same
/// detector and the same solver as for a session; its observations saved and solved again give the same rig.
/// Not thread safe.
class LiveCalibration {
 public:
  LiveCalibration(LiveTarget target, std::vector<CalibrationCamera> cameras);

  /// Looks for the target in every picture (on all cores). BadData names a camera whose picture has another
  /// size.
  Result<LiveInstant> look(const FrameSet& set) const;
  /// Keeps what look() found when it is new, and says so in instant.counted.
  void keep(const FrameSet& set, LiveInstant& instant);

  const Observations& observations() const { return observations_; }
  /// Mutable: what is known beforehand, and the gauge.
  Observations& observations() { return observations_; }
  int sets() const { return sets_; }        ///< looked at
  int counted() const { return counted_; }  ///< that counted

 private:
  bool is_new(const std::vector<Detection>& detections) const;
  LiveTarget target_;
  Observations observations_;
  std::vector<Detection> last_;
  int sets_ = 0, counted_ = 0;
};

/// A thinner copy for a quick solution while the operator waves: at most `frames` frames, evenly taken,
/// nothing held out. The links of the rig stay: frames that several cameras see go first.
Observations thinned(const Observations& observations, int frames);

}  // namespace floatstage::calib
