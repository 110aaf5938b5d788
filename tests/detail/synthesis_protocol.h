#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "detail/synthesis/color_grid.h"

namespace floatstage::detail::test {

/// A picture that a synthesis has to come near to, and what it is given (thesis 4.5, figure 25): the picture
/// shrunk by means over `zoom` x `zoom` pixels, and cut-outs of it at its full size.
struct SynthesisProtocol {
  Image truth, low;
  int zoom = 16;
  std::vector<Region> children;

  bool is_in_child(int x, int y, int margin = 0) const;
};

Image cut_out(const Image& image, const Region& region);
Image shrunk_by_means(const Image& image, int factor);

/// 2048 x 2048 pixels of ../shared/data/detail/panda and three children of 512 x 512.
Result<SynthesisProtocol> panda_protocol();

/// A picture that is no synthesis, or one that no program could make, and its name.
struct Variant {
  std::string name;
  Image picture;
};

/// The calibration of the gates: the truth, the truth moved by 1 and 4 px, the right coarse picture with
/// details from elsewhere, bicubic and Lanczos' interpolation, bicubic with an unsharp mask and with noise,
/// tiles of 32 px shuffled, and details averaged from eight places.
std::vector<Variant> variants_of(const SynthesisProtocol& protocol);

}  // namespace floatstage::detail::test
