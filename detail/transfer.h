#pragma once

#include <cstdint>
#include <vector>

#include "detail/float_picture.h"
#include "detail/seam.h"
#include "detail/structure.h"
#include "detail/tone_match.h"

namespace floatstage::detail {

struct TransferOptions {
  bool adapt = true;  ///< move the child's edges onto the parent's (thesis 4.3.2)
};

/// A child made to fit into its parent, step by step; everything in the child's pixels.
struct Transfer {
  LightPicture toned;              ///< the child, displaced, with the parent's tones
  std::vector<std::uint8_t> same;  ///< 1: both show the same (4.3.1), at most shifted where edges were moved
  Seam first_seam;                 ///< along which edges were matched first; empty without adaptation
  Structure structure;             ///< of the first round, with the displacement of all
  bool adapted = false;            ///< the displacement is used: the seam costs less with it
  double seam_cost = 0;            ///< of the first seam's kind, after the displacement
  Seam seam;                       ///< the one that is used
  LightPicture adjusted;  ///< displaced, its colours made to meet the parent's along the seam (4.3.3)
  Field alpha;            ///< how opaque it is (4.3.4)
  double correction = 0;  ///< mean of what the colours were changed by at the end, linear light
};

/// `child` and `parent` are of one size: the parent as it is seen through the homography. `zoom`: pixels of
/// the child in one that the parent has details for, >= 1; what is compared is blurred to that.
Transfer transfer_detail(const LightPicture& child, const LightPicture& parent, double zoom,
                         const TransferOptions& options = {});

}  // namespace floatstage::detail
