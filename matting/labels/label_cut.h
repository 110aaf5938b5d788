#pragma once

#include <vector>

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// What is known of each pixel before its label is chosen.
struct LabelEvidence {
  int count = 2;
  Image labels;  ///< 1 channel: where the search starts; pixels that are not asked keep theirs
  std::vector<std::uint8_t> asked;  ///< a pixel: 0 keeps its label
  std::vector<float> costs;         ///< of each asked pixel in order, `count` numbers: what a label costs
};

/// The labels of least sum of costs plus, for 8-neighbours of different labels, `smooth` times how alike
/// they look: one minimum cut for two labels; expansion moves for more, each exact (Y. Boykov, O. Veksler,
/// R. Zabih, "Fast Approximate Energy Minimization via Graph Cuts", PAMI 2001). Deterministic.
Image cut_labels(const Image& picture, const LabelEvidence& evidence, double smooth);

}  // namespace floatstage::matting
