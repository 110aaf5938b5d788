#pragma once

#include "core/image.h"

namespace floatstage::pipeline {

/// How far apart what is blended lies, 8-bit levels, mean over a mask (>= 128): from the heat map (RGBA) that
/// a renderer hands out as RenderOutput::Ghosting. NaN where the mask is empty.
double ghosting_of(const Image& heat, const Image& mask);

}  // namespace floatstage::pipeline
