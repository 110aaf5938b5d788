#pragma once

#include <iostream>
#include <string>
#include <vector>

#include "core/image.h"
#include "pipeline/metrics/matte_metrics.h"

namespace floatstage::matting {

/// Means over a clip, the first frame left out where it was given.
struct ClipScores {
  double mse = 0, iou = 0, dtssd = 0;
};

inline ClipScores score_clip(const std::vector<Image>& mattes, const std::vector<Image>& truth,
                             std::size_t first = 1) {
  ClipScores s;
  const double n = static_cast<double>(truth.size() - first);
  for (std::size_t f = first; f < truth.size(); ++f) {
    s.mse += pipeline::matte_mse(mattes[f], truth[f]) / n;
    s.iou += pipeline::matte_iou(mattes[f], truth[f]) / n;
  }
  for (std::size_t f = 1; f < truth.size(); ++f)
    s.dtssd += pipeline::matte_dtssd(mattes[f - 1], mattes[f], truth[f - 1], truth[f]) /
               static_cast<double>(truth.size() - 1);
  return s;
}

inline std::ostream& operator<<(std::ostream& out, const ClipScores& s) {
  return out << "MSE " << s.mse << ", dtSSD " << s.dtssd << ", IoU " << s.iou;
}

}  // namespace floatstage::matting
