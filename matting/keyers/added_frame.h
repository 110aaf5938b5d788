#pragma once

#include <memory>
#include <vector>

#include "core/image.h"
#include "matting/keyers/keyer.h"

// Private to the stage.
namespace floatstage::matting {

/// Rows and columns along a picture's sides that no lens has seen, px.
struct AddedFrame {
  int left = 0, top = 0, right = 0, bottom = 0;
  bool none() const { return left + top + right + bottom == 0; }
  bool operator==(const AddedFrame&) const = default;
};

/// The frame that a camera or a converter laid around pictures of one camera (letterbox bars, a dead column):
/// rows of one even colour at a side, in every picture, behind which most of the next row has another. A
/// stage's own black is none: it goes on inside. At most a quarter of the picture a side. `pictures`: RGB;
/// those of another size than the first are not looked at.
AddedFrame added_frame(const std::vector<Image>& pictures);

/// The part of a picture inside the frame.
Image inside(const Image& picture, const AddedFrame& frame);

/// A keyer that sees only what is inside the frame; the frame itself is background.
std::unique_ptr<Keyer> inside_keyer(std::unique_ptr<Keyer> keyer, const AddedFrame& frame);

}  // namespace floatstage::matting
