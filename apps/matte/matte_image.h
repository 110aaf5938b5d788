#pragma once

#include <filesystem>
#include <string>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

struct MatteImageOptions {
  std::string method = "auto";  ///< auto, chroma, closed-form
  Image picture;                ///< RGB
  Image trimap;                 ///< 0, 255, else unknown; empty: none
  Image scribbled;              ///< the picture with white and black scribbles; empty: none
};

/// One picture's matte. auto: closed form where there is a trimap or scribbles, else chroma with closed form in the band
/// around it if that explains the picture better. Errors: InvalidArgument for a method that there is not or that needs
/// what was not given, and for sizes that differ; NotFound when there is no cloth.
Result<Image> matte_image(const MatteImageOptions& options);

}  // namespace floatstage
