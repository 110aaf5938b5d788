#pragma once

#include <vector>

namespace floatstage::render {

/// Continues a picture of interleaved floats where it is not known: unknown pixels take the smooth
/// continuation of the known ones around them (pull-push over a pyramid, Gortler et al. 1996). Known pixels
/// stay as they are; with none known everything becomes 0. `known` has one entry a pixel, not 0 meaning
/// known.
void fill_unknown(int width, int height, int channels, const std::vector<bool>& known, float* values);

}  // namespace floatstage::render
