#pragma once

#include <span>
#include <vector>

#include "core/added_content.h"

namespace floatstage {

/// The bars around pictures of one camera: rows and columns of one colour at a side, in every picture, behind
/// which most of the next line has another. A stage's own black is none: it goes on inside. Text in a bar and
/// what a codec leaves at its edge belong to it. At most a quarter of the picture a side. `pictures`: RGB;
/// those of another size than the first are not looked at.
AddedContent added_bars(std::span<const Image> pictures);

/// What was added to the pictures of cameras; one entry each. `pictures[i]`: of camera i some instants, RGB,
/// of one size; the first of all cameras are of one instant.
///
/// Bars as above. Overlays are contours in the outer quarters of the pictures that stand at one place with
/// one look, where a lens cannot have put them: in three cameras or more, all of which see them so, while
/// around them the pictures differ or the contours are as fine as writing; or, as fine, in eight or more
/// pictures of one camera while the scene around them changes. Digits that change are taken along where
/// they stand in one line with what stays, in its colour. A still camera's still scene shows none: there a
/// stamp and a sign on the wall are the same.
std::vector<AddedContent> find_added(std::span<const std::vector<Image>> pictures);

}  // namespace floatstage
