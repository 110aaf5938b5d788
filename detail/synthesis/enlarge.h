#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "detail/compose.h"
#include "detail/photo_graph.h"
#include "detail/synthesis/row_writer.h"
#include "detail/watch.h"

namespace floatstage::detail {

struct EnlargeOptions {
  /// Of the root: 2, 4 … 64; 0: the power of two nearest to the closest photograph's zoom, as far as 32
  /// million pixels allow.
  int zoom = 0;
  /// Makes what the picture is written with while it is made, of its width and height; empty: the picture is
  /// kept.
  std::function<Result<std::unique_ptr<RowWriter>>(int, int)> writer = {};
  bool keep_provenance = true;
  double in_memory = 32e6;  ///< pixels up to which photographs are laid into the picture itself; beyond these
                            ///< they meet in one of 8 million (ComposeOptions::own_pixels)
  int tile = 256;  ///< px a side that one thread works on, 16 or more; the picture does not depend on it
  int threads = 0;
  Watch watch;
};

struct Enlargement {
  int width = 0, height = 0;
  Image picture;     ///< empty with a writer
  Image provenance;  ///< 1 channel: a Provenance a pixel; empty where it is not kept
  int zoom = 1;
  std::vector<ComposedPhoto> photos;
  std::array<double, 4> shares{};  ///< of the picture, by Provenance
  /// PSNR, dB, of the picture's means over zoom x zoom pixels against the root, where no photograph is laid;
  /// at most 99.
  double like_root = 99;
};

/// The root enlarged, the photographs below it carried into it (compose()), and everywhere else details made
/// up of theirs (Synthesis). Errors: those of compose(); InvalidArgument for another zoom, or nothing lies
/// below the root, or when the picture would have more than 32 million pixels (with a writer: 1,000 million,
/// and the photographs would cover more than 32 million of them); the writer's.
///
/// Beyond 32 million pixels photographs meet in a picture of 8 million (ComposeOptions::own_pixels).
Result<Enlargement> enlarge(const PhotoGraph& graph, const EnlargeOptions& options);

/// Red synthesised, green warped, blue real, grey upsampled.
Image provenance_picture(const Image& provenance);

}  // namespace floatstage::detail
