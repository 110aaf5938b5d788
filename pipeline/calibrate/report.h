#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calib/calibrate.h"
#include "core/result.h"
#include "pipeline/calibrate/session.h"
#include "pipeline/calibrate/verdict.h"

namespace floatstage::pipeline {

/// What the report says beside the calibration itself.
struct ReportContext {
  std::string title;  ///< the session's name
  std::vector<std::string>
      detection;  ///< a sentence a camera: how many pictures show the target, and why others do not
  std::vector<std::string> remarks;
  double detection_seconds = 0;
  calib::WorkingVolume volume = {};  ///< where the calibration must hold; empty: where its targets were
};

/// {pass, cameras[{serial, rms_px, p95_px, holdout_px, sigma{…}, …}], scale{…}, lengths[…], failures[…],
/// bars[…], volume{…}, links[…], remarks[…], detection[…], seconds}.
nlohmann::json report_json(const calib::Calibration& calibration, const Verdict& verdict,
                           const ReportContext& context);

/// One page with everything in it, pictures too (SVG): verdict, bars, per camera error vectors, coverage and
/// projection uncertainty, the cameras from above with their links, known lengths. Needs no other file and no
/// network.
std::string report_html(const calib::Calibration& calibration, const Verdict& verdict,
                        const ReportContext& context);

/// Writes calibration.html and calibration.json into a folder, which is made when needed.
Result<void> save_report(const calib::Calibration& calibration, const Verdict& verdict,
                         const ReportContext& context, const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
