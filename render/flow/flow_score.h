#pragma once

#include <cstddef>

#include "core/image.h"
#include "core/result.h"
#include "render/flow.h"

namespace floatstage::render {

/// How far a field is from the truth, over all pixels whose truth is_known(), the border included.
struct FlowScore {
  double epe = 0;         ///< mean end-point error, px
  double aae = 0;         ///< mean angle between (u, v, 1) and the truth's, degrees (Barron et al. 1994)
  std::size_t known = 0;  ///< pixels; with 0 the errors are NaN
};
/// InvalidArgument for fields of different sizes.
Result<FlowScore> score_flow(const FlowField& field, const FlowField& truth);

/// The field in the colours of Middlebury's evaluation (Baker et al. 2011): hue is the direction, paleness
/// the lack of length; longer than `largest` px is darkened, and what is not known black. `largest` 0: the
/// longest displacement of the field. RGB.
Image flow_picture(const FlowField& field, double largest = 0);

}  // namespace floatstage::render
