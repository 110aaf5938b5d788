#pragma once

#include <cstdint>
#include <vector>

#include "detail/float_picture.h"

namespace floatstage::detail {

/// Which pixels the child gives: 1; the parent: 0. One a pixel of the child.
struct Seam {
  std::vector<std::uint8_t> child;
  double energy = 0;  ///< Eq. 4.2 over the seam at the size at which it was found last
};

/// The seam that is seen least (thesis 4.3.2.1, Eq. 4.2): a minimum cut of colour differences less their mean
/// along the seam, cut again until that mean no longer helps; first at no more than 512 px a side, then in a
/// band around it at full size. The outermost 2 px are the parent's; what lies deeper than 15 % of the
/// shorter side is the child's, so that no cheap seam gives it all away; pixels where `same` is 0 are the
/// parent's.
Seam find_seam(const LightPicture& child, const LightPicture& parent, const std::vector<std::uint8_t>& same);

}  // namespace floatstage::detail
