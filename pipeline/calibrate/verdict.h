#pragma once

#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/uncertainty/working_volume.h"
#include "pipeline/calibrate/session.h"

namespace floatstage::pipeline {

/// One number of a calibration against its bar. What was not measured reaches its bar only where nobody asked
/// for it by name (`required`): a default bar says nothing of what is not there.
struct BarCheck {
  std::string what;    ///< "rms_px"
  std::string camera;  ///< serial; empty for the whole rig
  Measured value;
  double bar = 0;
  bool pass = false;
  bool required = false;
};

struct Verdict {
  bool pass = false;  ///< every bar is reached and nothing is wrong with the capture
  std::vector<BarCheck> checks;
};

/// `volume`: where the projection sigma is taken.
Verdict judge(const calib::Calibration& calibration, const CalibrationBars& bars,
              const calib::WorkingVolume& volume);
/// Over the convex hull of all targets.
Verdict judge(const calib::Calibration& calibration, const CalibrationBars& bars);

/// Adds a number to a verdict; it passes when it is at most its bar. NaN passes no bar.
void add_check(Verdict& verdict, const calib::Calibration& calibration, BarCheck check);

/// PASS, or FAIL and the reasons; behind either what was not measured, and why.
std::string describe(const calib::Calibration& calibration, const Verdict& verdict);

}  // namespace floatstage::pipeline
