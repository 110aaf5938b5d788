#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace floatstage {

/// A subject cut out with exact opacity: what is moved in front of a backdrop.
struct Cutout {
  Image color;  ///< RGB, straight: the subject's own colour wherever it shows
  Image alpha;  ///< 1 channel
};

/// The dancer of the embedded studio, seen by one of its cameras, loose strands included.
Cutout studio_cutout(std::uint64_t seed, int width = 480, int height = 480);

/// Backdrops of any size from a seed: cloth with folds, lit unevenly; and a cluttered place with shapes and
/// textures whose colours are those of people too.
Image green_cloth(int width, int height, std::uint64_t seed);
Image cluttered_place(int width, int height, std::uint64_t seed);

struct ClipOptions {
  int width = 360, height = 240, frames = 12;
  std::uint64_t seed = 1;
  double scale = 0.45;  ///< of the cutout in the picture
  double noise = 2;     ///< standard deviation, 8-bit steps
  double turn = 2.5;    ///< degrees a frame, in the seed's direction
  double speed = 3.5;   ///< px a frame
};

/// Photographs with their exact mattes: colour = a F + (1 - a) B with a the mean of 16 samples a pixel of the
/// moved cutout, then noise and 8 bits.
struct MatteClip {
  std::vector<Image> frames, truth;
  Image plate;
};
MatteClip make_clip(const Cutout& cutout, const Image& backdrop, const ClipOptions& options);

}  // namespace floatstage
