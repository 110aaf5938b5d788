#pragma once

#include <string_view>

#include "core/image.h"

namespace floatstage::detail {

/// How a photograph's file wants to be turned before it is shown: tag 274 of EXIF 2.32 (4.6.4) and TIFF 6.0,
/// 1…8. Of a JPEG (APP1 "Exif"), a PNG (chunk eXIf) or a TIFF, known by its first bytes. 1 where nothing is
/// said, or where what is said makes no sense: a photograph with a broken remark is still a photograph.
int exif_orientation(std::string_view file);

/// The picture as it is to be seen: turned and mirrored by an orientation of 1…8; others leave it as it is.
Image upright(Image picture, int orientation);

}  // namespace floatstage::detail
