#pragma once

#include <map>
#include <string>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/camera_path.h"
#include "pipeline/evaluate/evaluate.h"

namespace floatstage::pipeline {

/// How steadily a method shows a surface that stands still while the view moves (docs/metrics.md).
struct TemporalScores {
  double jitter = 0;  ///< 8-bit levels: mean second difference of a surface point's colour over the steps
  double jitter_p999 = 0;  ///< its 99.9 % percentile
  double pop = 0;          ///< the worst step's 99.9 % of first differences over the median step's
  int set_changes = 0;     ///< steps at which another set of photographs is blended
  int steps = 0;           ///< from picture to picture
  double points = 0;       ///< surface points seen in three pictures in a row, mean over the steps
};

struct PathPictures {
  CameraPath path;
  int count = 200;  ///< pictures, evenly over the way that the camera makes along the path
};

/// Walks around the first of options.frames and follows points of its proxy (options.proxy, nobody left out;
/// options.inputs are drawn from). Pictures have the first input's size by options.scale. One score a method.
/// InvalidArgument for a path of one key or fewer than four pictures; BadData where no point of the surface
/// is ever seen.
Result<std::map<std::string, TemporalScores>> evaluate_path(capture::TakeReader& take,
                                                            const EvaluateOptions& options,
                                                            const PathPictures& along);

}  // namespace floatstage::pipeline
