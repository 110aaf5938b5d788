#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/calibrate/report.h"

namespace floatstage::pipeline {

/// Where what came out of a calibration goes; empty paths: nowhere.
struct OutcomeOptions {
  std::string name;  ///< of the session, for the sentence
  std::filesystem::path out, report, json;
  bool keep_failed = false;           ///< write the rig even when it does not pass
  std::vector<std::string> left_out;  ///< serials that were solved for but are not of the rig
};

/// Judges a calibration by its bars and `checks` (whose `pass` is filled in), prints it, writes report, JSON
/// and, when it passes, the rig. BadData when it does not pass.
Result<void> write_outcome(const calib::Calibration& calibration, const CalibrationBars& bars,
                           const std::vector<BarCheck>& checks, const ReportContext& context,
                           const OutcomeOptions& options);

}  // namespace floatstage::pipeline
