#pragma once

#include <vector>

#include "core/image.h"
#include "matting/labels/label_clip.h"

// Private to the stage.
namespace floatstage::matting {

/// The labels of a frame as they came from one of the key frames on either side of it.
struct LabelsFromKey {
  const Image& labels;
  const std::vector<double>& lost;  ///< of each label, what it lost on the whole way to the other key frame
  double way = 0;                   ///< how much of that way lies behind this frame, 0 to 1
};

/// The labels of a frame between two key frames, where both directions speak: each by what its labels have
/// probably lost until here, which is their loss on the whole way times the way. So a key frame is not heard
/// where the other one's labels are known to hold.
Image join_labels(const Image& picture, const LabelsFromKey& before, const LabelsFromKey& after, int count,
                  const LabelClipOptions& options);

}  // namespace floatstage::matting
