#pragma once

#include "core/matte.h"

namespace floatstage::recon {

/// Hausdorff distance of two masks of one size, px between pixel centres: how far the most distant pixel of
/// either is from the other. 0 when they are equal; the picture's diagonal when only one is empty. Fast when
/// they are alike.
double mask_distance(const Matte& a, const Matte& b);

}  // namespace floatstage::recon
