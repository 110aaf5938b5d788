#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "matting/spectral/spectral_matting.h"

namespace floatstage::apps {

/// How a matte is looked at.
enum class MatteView {
  Photograph,  ///< as it was taken
  Checker,     ///< the subject over a chessboard
  Color,       ///< the subject over one colour, in which the old background shows
  Matte,       ///< opacity as grey
  Difference,  ///< what came since the frame before in green, what went in red, over the matte at half its
               ///< brightness
  Components,  ///< matting components, each in a colour of its own, over the photograph's brightness
  Labels,  ///< the matte's labels, each in a colour of its own, over the photograph; what is nobody's stays
           ///< white
};

/// In the order of the enumeration, as menus and the command line have them.
const std::vector<std::string>& matte_view_names();

struct MatteViewInput {
  Image photograph;                       ///< RGB
  Image matte;                            ///< 1 channel, of its size; empty: there is none
  Image before;                           ///< the matte of the frame before; empty: there is none
  matting::MattingComponents components;  ///< of any size; empty: not known yet
  std::vector<Image> labels = {};  ///< each one's matte, of its size; empty: of that label there is none
  std::array<std::uint8_t, 3> color = {255, 0, 255};
};

/// The picture of a view, RGB, of the photograph's size. What a view needs and does not have (a matte,
/// components, labels) is shown as the photograph at a third of its brightness; without a frame before,
/// nothing has changed.
Image matte_picture(MatteView view, const MatteViewInput& input);

/// The colour of a component in MatteView::Components, and of a label in MatteView::Labels.
std::array<std::uint8_t, 3> component_color(int component);

}  // namespace floatstage::apps
