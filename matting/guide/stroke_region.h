#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "matting/color_model.h"

// Private to the stage.
namespace floatstage::matting {

/// The colours of a frame's two sides, as its matte was before anybody said anything.
struct SideColors {
  ColorModel subject, background;
  SideColors(const Image& picture, const Image& sides);
};

/// A frame that is being guided. All pictures have one size.
struct StrokeScene {
  const Image& picture;  ///< RGB
  const Image& sides;    ///< 255 subject, 0 background, before the stroke
  const Image& said;     ///< 255 and 0 where somebody said it, this stroke included; 128 elsewhere
  const SideColors& colors;
};

/// What a stroke turns over: pixels of the other side that hang together with what it marks wrongly labelled,
/// up to where colour and contour end. `print` is 255 where it was drawn, `side` what it says (0 or 255).
///
/// A minimum cut in a window around the stroke weighs the stroke's colours against those of the side that
/// stands there, in the window and in the whole frame, and contrast. What is much thicker than the place of
/// the stroke stays. A tiny island or hole, and one that is marked in its middle and is a thing of its own,
/// turns as a whole. What others said stays. A region without contours of its own is not believed beyond the
/// 0.4 % of the subject that are nearest to the stroke.
/// Nothing turns when the print is on its side already. Deterministic.
struct StrokeRegion {
  Image turned;        ///< 255 where pixels turn
  int step = 1;        ///< px: how exact its outline is
  bool whole = false;  ///< an island or hole as a whole
};
StrokeRegion stroke_region(const StrokeScene& scene, const Image& print, std::uint8_t side);

}  // namespace floatstage::matting
