#pragma once

#include <array>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "detail/compose.h"
#include "detail/photo_graph.h"
#include "detail/watch.h"

namespace floatstage::detail {

struct EnlargeOptions {
  int zoom = 0;  ///< of the root: 2, 4 … 64; 0: the power of two nearest to the closest photograph's zoom, as
                 ///< far as 32 million pixels allow
  int tile = 256;  ///< px a side that one thread works on, 16 or more; the picture does not depend on it
  int threads = 0;
  Watch watch;
};

struct Enlargement {
  Image picture;
  Image provenance;  ///< 1 channel: a Provenance a pixel
  int zoom = 1;
  std::vector<ComposedPhoto> photos;
  std::array<double, 4> shares{};  ///< of the picture, by Provenance
  /// PSNR, dB, of the picture's means over zoom x zoom pixels against the root, where no photograph is laid;
  /// at most 99.
  double like_root = 99;
};

/// The root enlarged, the photographs below it carried into it (compose()), and everywhere else details made
/// up of theirs (Synthesis). Errors: those of compose(); InvalidArgument for another zoom or when the picture
/// would have more than 32 million pixels, or nothing lies below the root.
Result<Enlargement> enlarge(const PhotoGraph& graph, const EnlargeOptions& options);

/// Red synthesised, green warped, blue real, grey upsampled.
Image provenance_picture(const Image& provenance);

}  // namespace floatstage::detail
