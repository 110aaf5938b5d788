#include "pipeline/label.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "core/synthetic/bitmap_font.h"

namespace floatstage::pipeline {

void label(Image& rgb, int x, int y, int of_height, std::string_view words) {
  std::string line(words);
  std::transform(line.begin(), line.end(), line.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  // A line is a thirtieth of the picture, and legible in small ones.
  const float dot = std::max(1.F, static_cast<float>(of_height) / (30 * synthetic::kGlyphHeight));
  const float margin = 3 * dot;
  const int width = static_cast<int>(std::ceil(synthetic::printed_width(line) * dot + 2 * margin)),
            height = static_cast<int>(std::ceil(synthetic::kGlyphHeight * dot + 2 * margin));
  constexpr float kShade = 0.35F;
  for (int j = std::max(0, -y); j < height && y + j < rgb.height; ++j)
    for (int i = std::max(0, -x); i < width && x + i < rgb.width; ++i) {
      const float ink = synthetic::printed_ink(line, (static_cast<float>(i) + 0.5F - margin) / dot,
                                               (static_cast<float>(j) + 0.5F - margin) / dot, 1 / dot);
      std::uint8_t* pixel = rgb.at(x + i, y + j);
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(
            std::lround(kShade * static_cast<float>(pixel[c]) * (1 - ink) + 255 * ink));
    }
}

}  // namespace floatstage::pipeline
