#pragma once

#include <optional>
#include <vector>

#include "core/image.h"
#include "core/matte.h"

namespace floatstage::matting {

/// A photograph with a matte drawn in, at most `longest` px a side: a third as bright where the matte has no
/// subject, with its outline in red; the outline of what the other cameras say in light blue.
Image doubt_tile(const Image& rgb, const Matte& matte, const std::optional<Matte>& others, int longest);

/// Tiles beside and below one another, about as wide as high; black between pictures of unequal sizes. Empty
/// without any.
Image contact_sheet(const std::vector<Image>& tiles);

}  // namespace floatstage::matting
