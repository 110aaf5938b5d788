#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "pipeline/metrics/matte_metrics.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct CameraMatteScores {
  std::string serial;
  int frames = 0;               ///< that have a matte and a truth
  MatteScores mean;             ///< over them
  std::optional<double> dtssd;  ///< mean over the pairs of frames that follow one another; absent without one
  double worst_iou = 1;
  int worst_frame = -1;
  MatteEffort effort;  ///< from mattes/edits.json
};

/// Mattes of a take, or of the labels that are chosen from it, against true ones. `truth` holds
/// <serial>/<frame>.png, or <serial>/<label>/<frame>.png of each, like mattes/; a camera or frame
/// without a truth is left out, NotFound when none is left. BadData for a matte of another size than its
/// truth.
Result<std::vector<CameraMatteScores>> evaluate_mattes(const capture::TakeReader& take,
                                                       const std::filesystem::path& truth,
                                                       const std::vector<int>& frames,
                                                       Progress* watch = nullptr);

}  // namespace floatstage::pipeline
