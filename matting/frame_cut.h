#pragma once

#include <vector>

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// The evidence of one frame, to be cut.
struct CutEvidence {
  std::vector<float> odds;          ///< a pixel: log of how much likelier subject is than background
  std::vector<std::uint8_t> asked;  ///< a pixel: 0 is background without being asked, which costs nothing, 2
                                    ///< likewise subject; any other is asked
  std::vector<float> calm;  ///< a pixel: 1; towards 0 where the backdrop itself has an edge, which says
                            ///< nothing about the subject's
};

/// The cheapest split into subject (255) and background (0): sum of the odds of pixels on the wrong side
/// plus, for 8-neighbours on different sides, `smooth` times how alike they look (Boykov, Jolly 2001, with
/// the backdrop's own edges taken off as in Sun et al., "Background Cut", 2006). Exact: a minimum cut.
/// Deterministic.
Image cut_frame(const Image& picture, const CutEvidence& evidence, double smooth);

}  // namespace floatstage::matting
