#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"
#include "core/result.h"

namespace floatstage::pipeline {

struct MatteImageOptions {
  std::string how = "auto";              ///< auto, chroma, closed-form, pyramid, spectral
  Image picture;                         ///< RGB
  Image trimap;                          ///< 0, 255, else unknown; empty: none
  Image scribbled;                       ///< the picture with white and black scribbles; empty: none
  std::vector<MatteStroke> clicks = {};  ///< px of the picture; they outrank the others
};

/// One picture's matte. auto: closed form from coarse to fine (pyramid) where there is a trimap or scribbles,
/// spectral where there are clicks alone, else chroma with closed form in the band around it if that explains
/// the picture better. Errors: InvalidArgument for a method that there is not or that needs what was not
/// given, for sizes that differ, and where only the subject or only the background is marked; NotFound when
/// there is no cloth.
Result<Image> matte_image(const MatteImageOptions& options);

}  // namespace floatstage::pipeline
