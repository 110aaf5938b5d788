#pragma once

#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "pipeline/calibrate/session.h"

namespace floatstage::pipeline {

/// One number of a calibration against its bar.
struct BarCheck {
  std::string what;    ///< "rms_px"
  std::string camera;  ///< serial; empty for the whole rig
  double value = 0, bar = 0;
  bool pass = false;
};

struct Verdict {
  bool pass = false;  ///< every bar is reached and nothing is wrong with the capture
  std::vector<BarCheck> checks;
};

Verdict judge(const calib::Calibration& calibration, const CalibrationBars& bars);

/// Adds a number to a verdict; it passes when it is at most its bar.
void add_check(Verdict& verdict, const calib::Calibration& calibration, BarCheck check);

/// One sentence: PASS, or FAIL and the first reasons.
std::string describe(const calib::Calibration& calibration, const Verdict& verdict);

}  // namespace floatstage::pipeline
