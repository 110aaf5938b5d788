#pragma once

#include <vector>

#include "core/image.h"
#include "matting/video/frame_flow.h"

// Private to the stage.
namespace floatstage::matting {

/// Where the pixels of a frame were some frames ago, flow after flow; at the picture's border flow goes on
/// beyond it. What came to light since then has no ancestor of its own: flow draws it out of a thin strip of
/// what hid it.
class LabelDescent {
 public:
  LabelDescent() = default;
  /// Begins with a frame of this size.
  LabelDescent(int width, int height);

  /// One frame on: `back` is where each of its pixels was in the frame before.
  void follow(const FrameFlow& back);

  /// `labels` of the frame, 0 … `count` - 1, 0 the background: 255 where a label has matter that came to
  /// light and hangs at it from outside, as a car that comes out from behind a sleeve does. What comes to
  /// light within a label, behind its own arm, is not named, nor is what flow cannot resolve.
  Image fresh(const Image& labels, int count) const;

 private:
  struct Places {
    std::vector<float> at;  // x, y of each pixel, interleaved
    int age = 0;            // frames
  };
  Places here() const;
  void follow(Places& places, const FrameFlow& back) const;
  std::vector<float> areas() const;

  int width_ = 0, height_ = 0;
  Places since_, next_;      // what is asked, and what takes its place when it is too old
  std::vector<float> area_;  // of each pixel, the area that it had, by since_
};

}  // namespace floatstage::matting
