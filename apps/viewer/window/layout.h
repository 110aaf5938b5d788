#pragma once

#include <array>
#include <functional>

namespace floatstage::apps {

/// What draws itself into the three parts of the player's window, in this order; each into its own ImGui
/// window.
struct WindowParts {
  std::function<void()> controls;  ///< at the left
  std::function<void()> strip;     ///< along the bottom
  std::function<void()> stage;     ///< the rest, without borders, on the background
};

/// Height of the letters on a display of ordinary pixels.
inline constexpr float kFontPixels = 13;

/// How much larger than that they are here; widths and heights of widgets go with it. Inside a frame.
float ui_scale();

/// One frame of the window, of ImGui's present size. `strip_height` is in px before ui_scale(); `background`
/// RGB, 0 to 1.
void lay_out_window(float strip_height, const std::array<float, 3>& background, const WindowParts& parts);

}  // namespace floatstage::apps
