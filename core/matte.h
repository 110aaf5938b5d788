#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/frame.h"
#include "core/image.h"

namespace floatstage {

/// Opacity of the subject in one photograph: 0 background … 255 subject, in the photograph's own (distorted)
/// pixels. A handle, shared and read-only. An empty matte means "this camera does not know": it never carves.
struct Matte {
  FrameInfo source;
  int width = 0, height = 0;
  std::size_t stride = 0;  ///< bytes from one row to the next
  std::shared_ptr<const std::uint8_t[]> alpha;

  bool empty() const { return alpha == nullptr; }
  const std::uint8_t* row(int y) const { return alpha.get() + static_cast<std::size_t>(y) * stride; }
};

/// A Matte that owns a copy of a one-channel image, and back.
Matte make_matte(FrameInfo source, const Image& alpha);
Image to_image(const Matte& matte);

/// Fraction of pixels with alpha >= 128.
double coverage(const Matte& matte);

/// Intersection over union of two mattes thresholded at 128; 1 when both are empty of subject. Sizes must
/// agree.
double iou(const Matte& a, const Matte& b);

}  // namespace floatstage
