#pragma once

#include <string_view>

namespace floatstage::synthetic {

/// Capital letters, digits and '-' on a grid of 5 x 7 dots, 6 dots from one letter to the next.
inline constexpr int kGlyphWidth = 5, kGlyphHeight = 7, kGlyphAdvance = 6;

/// Ink at a place of a printed line, 0…1. `x` to the right and `y` down, in dots, from the line's top-left
/// corner; `width` is the size of the window to average over, in dots. The dots are joined and rounded as by
/// a printer.
float printed_ink(std::string_view line, float x, float y, float width);

/// Width of a line in dots.
float printed_width(std::string_view line);

}  // namespace floatstage::synthetic
