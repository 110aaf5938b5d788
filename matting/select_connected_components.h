#pragma once

#include "core/image.h"

namespace floatstage::matting {

/// Which separate parts of a key are the subject, when a person or the frame before says so.
///
/// `key`: 1 channel; its islands are the connected parts of opacity >= 128. `previous` (empty, or of its
/// size): the chosen matte of a neighbouring frame; an island stays when a quarter of it, or a quarter of
/// `previous`, lies within `reach` px of `previous`. `said` (empty, or of its size): 255 and 0 where a stroke
/// marks subject and background, 128 elsewhere; an island that a subject stroke touches stays, one that only
/// a background stroke touches goes. Without `previous` only touched islands stay, and all others when no
/// subject stroke touches any. Soft edges of what stays are kept; what goes is 0.
Image select_connected_components(const Image& key, const Image& previous, const Image& said, int reach);

}  // namespace floatstage::matting
