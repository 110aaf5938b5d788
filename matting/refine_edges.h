#pragma once

#include <functional>

#include "core/image.h"

// Private to the stage: the last step of the colour keyers.
namespace floatstage::matting {

/// Writes the pixels x0 … x0 + count - 1 of row y of a measure that tells subject and backing apart to `out`.
/// It must be linear in the share that each has in a pixel, and 0 where nothing is known of the subject; its
/// unit does not matter.
using BackingMeasure = std::function<void(int y, int x0, int count, float* out)>;

/// Solves the opacity of the pixels along the subject's edge and in its loose hair. A key only says how much
/// a pixel looks like cloth, which for a mixed pixel depends on how bright the two sides are there. With a
/// linear measure s of the cloth, a pixel of which the subject covers the share a has s = a s_F + (1 - a) s_B
/// (Smith and Blinn 1996, eq. 1, along one axis); s_F and s_B are the means over the nearby inside of the
/// subject and the nearby backing, and s_F is 0 where no inside is near. Inside the subject everything
/// becomes opaque.
///
/// `alpha`: the cleaned key. `doubt`, of its size: not 0 where a pixel may be less than all cloth; hair is
/// looked for there where it hangs together with the subject. Edges keep their key where s_F is within
/// `contrast` of s_B.
void refine_edges(const BackingMeasure& measure, float contrast, const Image& doubt, Image& alpha);

}  // namespace floatstage::matting
