#pragma once

#include "core/image.h"
#include "matting/video/frame_flow.h"

// Private to the stage.
namespace floatstage::matting {

/// Labels of one frame brought to a neighbouring one.
struct CarriedLabels {
  Image labels;    ///< 1 channel, of the new frame: each label where its own inside went
  Image dense;     ///< the same along dense flow
  Image doubtful;  ///< 255 where the flow there and back do not meet, colours changed, or what moves there
                   ///< does not move as the label does
  FrameFlow back;  ///< where each pixel of the new frame was
  std::vector<double> unfound;  ///< of each label along dense flow, the share that flow does not find again
};

/// `from`, `to`: RGB of one size, at least 32x32; `labels` of theirs, 0 … `count` - 1. A label goes where its
/// own inside within `reach` px goes, since dense flow beside an edge is often that of the other side.
/// Deterministic.
CarriedLabels carry_labels(const Image& from, const Image& labels, int count, int reach, const Image& to);

}  // namespace floatstage::matting
