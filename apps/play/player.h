#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "render/renderer.h"

namespace floatstage {

struct PlayOptions {
  std::filesystem::path take;
  std::string method = "floating";
  std::string compare;              ///< method of the right half; empty: no split
  int frame = 0;
  bool show_cameras = false, playing = false;
  std::filesystem::path path_file;  ///< camera path to begin with; empty: none
  int width = 1280, height = 800;   ///< window, px
  std::filesystem::path screenshot;  ///< write the window to this PNG once the picture stands, then end
  RendererOptions renderer;
};

/// The interactive player on a processed take. Returns when the window is closed.
Result<void> play_take(const PlayOptions& options);

}  // namespace floatstage
