#pragma once

#include <span>

#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A picture whose matte is believed.
struct Witness {
  Image picture;  ///< RGB
  Matte matte;    ///< of its size
};

struct RekeyOptions {
  int working_pixels = 100'000;  ///< it is cut at about so many; 2'000 … 1'000'000
  int turns = 4;                 ///< of colours and cut; 1 … 50
  int threads = 1;               ///< 0: one per core; the result is the same at any number
};

/// The matte of a picture whose own key failed, from what the other cameras of the instant know: the subject
/// lies within the silhouette of their hull, has the colours that their mattes show, and stands before what
/// this picture shows outside that silhouette. Colours and cut take turns, as in ConsistentMatting, with all
/// mattes but one held fast. `picture` is RGB; `hull`, of its size, is 255 where the hull of the others is
/// seen. Closed form solves the edges. Errors: InvalidArgument for sizes that do not fit; BadData when the
/// hull is not seen at all, fills the picture, or nobody is a witness.
Result<Image> rekey(const Image& picture, const Matte& hull, std::span<const Witness> witnesses,
                    const RekeyOptions& options);

}  // namespace floatstage::pipeline
