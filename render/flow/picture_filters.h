#pragma once

#include <vector>

#include "render/flow/picture_pyramid.h"

namespace floatstage::render {

// The filters of a pyramid. They mix only what lies in the domain, so that nothing of what is beyond the
// proxy's outline comes in. `scratch` keeps its memory between calls.

/// Gives a level its size; contents are left as they are.
void resize(PictureLevel& level, int width, int height);

/// (1 2 1)/4 around each pixel in both directions; zones and evidence are copied.
void smooth(const PictureLevel& raw, PictureLevel& to, std::vector<float>& scratch);

/// Half the size: (1 3 3 1)/8 around each pair in both directions. Domain is where any of the four pixels
/// is, evidence their share of it.
void halve(const PictureLevel& fine, PictureLevel& coarse, std::vector<float>& scratch);

/// The mean brightness of domain and band among the eight pixels around pixel `index`.
float mean_of_known(const PictureLevel& level, int index);

}  // namespace floatstage::render
