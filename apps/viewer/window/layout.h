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

/// One frame of the window, of ImGui's present size. `strip_height` is in px; `background` RGB, 0 to 1.
void lay_out_window(float strip_height, const std::array<float, 3>& background, const WindowParts& parts);

}  // namespace floatstage::apps
