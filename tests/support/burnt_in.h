#pragma once

#include <string>

#include "core/added_content.h"
#include "core/image.h"

namespace floatstage {

enum class StampLook {
  Plain,     ///< white
  Outlined,  ///< white, black around
  Boxed,     ///< white on a black box
  Dark,      ///< black
};

/// Writing as recorders burn it in.
struct Stamp {
  std::string words;
  double x = 0.03, y = 0.04;  ///< of its upper left corner, in widths and heights of the picture
  double size = 0.035;        ///< height of a digit, in heights of the picture
  int font = 0;               ///< Hershey's, as OpenCV numbers them: 0 sans, 2 bold, 3 serif, 4 bold serif
  StampLook look = StampLook::Plain;
};

/// Writes it into an RGB picture; what it covers.
PixelBox burn_in(const Stamp& stamp, Image& picture);

/// The picture with bars of one grey laid over its sides.
Image with_bars(Image picture, const AddedContent& bars, std::uint8_t grey = 0);

/// As a JPEG of that quality gives it back.
Image coded(const Image& picture, int quality);

}  // namespace floatstage
