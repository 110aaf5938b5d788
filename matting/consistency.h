#pragma once

#include <vector>

#include "core/image.h"
#include "matting/plate.h"

namespace floatstage {

/// How well each of several mattes of one picture explains it, where they differ or are soft: what `auto` chooses by,
/// since a picture brings no truth along.
///
/// Where all candidates agree on subject or on background, the picture's own colours are theirs; from there both are
/// extended smoothly into the rest (a known plate replaces the extended background where it is confident). There each
/// candidate a must compose the picture: the residual is the mean of |I - a F - (1 - a) B| over those pixels, in 8-bit
/// steps, errors cut off at 48. A candidate without any subject, where another has some, gets infinity; so does one that has
/// another size. All zero where the candidates are hard and equal.
/// `picture`: RGB; `candidates`: one channel each; `plate`: null or of the picture's size. Deterministic.
std::vector<double> composite_residuals(const Image& picture, const std::vector<Image>& candidates, const Plate* plate = nullptr);

}  // namespace floatstage
