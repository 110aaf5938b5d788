#pragma once

#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"
#include "matting/guide/guided_matte.h"

namespace floatstage::matting {

/// What somebody marked in a frame of a clip: a label's (1 …), nobody's (background), or, as 0, subject of
/// which nobody says whose it is. Background has no label.
struct LabelStroke {
  int label = 0;
  MatteStroke stroke;
};

struct StrokedLabels {
  Image labels;
  std::vector<StrokeEffect> effects;  ///< one a stroke
  std::vector<long> turned;           ///< one a stroke: pixels that it does not mark and that turned with it
};

/// The labels of a frame, 0 where there is none, as strokes say, one after the other. What a stroke marks is
/// as it says, exactly; where part of that was another label's or nobody's, what hangs together with it turns
/// too (guided_matte()), out of the background and out of other labels. Background turns what hangs together
/// with it of each label that it lies on. A stroke of the subject that names nobody is of the label that it
/// lies on, or that is nearest to it; where there is none, of label 1. All other pixels stay. `picture`: RGB
/// of the labels' size; errors: those of guided_matte().
Result<StrokedLabels> stroke_labels(const Image& picture, const Image& labels,
                                    const std::vector<LabelStroke>& strokes);

}  // namespace floatstage::matting
