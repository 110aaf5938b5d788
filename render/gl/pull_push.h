#pragma once

#include <vector>

#include "render/gl/kernel.h"

namespace floatstage::render::gl {

/// PictureFill on the GPU: continues pictures of two values a pixel, a layer of an array each, where they are
/// not known. The last step, at full size, is the caller's own kernel: fill.glsl's filled(). GL thread.
class PullPush {
 public:
  static Result<PullPush> create();

  /// What a kernel writes: two values and how far they are known, 0 … 1. `half`: as 16-bit floats.
  const Texture& begin(int width, int height, int layers, bool half);

  /// Once that is written: what it is continued by, of half the size. Lives until the next begin().
  struct Surroundings {
    const Texture* texture;
    int width, height;
    const Texture* all;  ///< of one pixel: the third value is 0 where nothing is known
  };
  Surroundings surroundings();

 private:
  PullPush() = default;
  void run(Kernel& kernel, std::size_t level, Kernel::Textures read, const Texture& written);

  /// What is known at one size, and what that is filled to.
  struct Level {
    int width = 0, height = 0;
    Texture known, whole;
  };
  Kernel pull_, push_;
  std::vector<Level> levels_;  // more than count_ are kept for their storage
  std::size_t count_ = 0;
  int layers_ = 0;
};

}  // namespace floatstage::render::gl
