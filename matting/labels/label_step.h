#pragma once

#include <vector>

#include "core/image.h"
#include "matting/labels/label_clip.h"

// Private to the stage.
namespace floatstage::matting {

/// What a neighbouring frame says of this one, and how much it is to be heard beside others.
struct LabelHint {
  Image labels, doubtful;    ///< as carry_labels() gives them
  std::vector<float> share;  ///< of each pixel, all hints together 1; empty: all hints the same
  Image fresh = {};  ///< 255 where what a label is said to have came to light lately: the carried edge
                     ///< says nothing of it; empty: nowhere
};

/// A picture of about this place whose labels are known, to learn colours from; labels from `count` on are
/// left out.
struct LabelSample {
  const Image& picture;
  const Image& labels;
};

/// The labels of a frame from what hints say: near their edges, and wherever they differ, the cut of one
/// energy of colours in local windows, distance to carried edges and contrast. `count` with the background.
/// Deterministic.
Image label_frame(const Image& picture, const std::vector<LabelHint>& hints, const LabelSample& sample,
                  int count, const LabelClipOptions& options);

}  // namespace floatstage::matting
