#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "apps/viewer/detail/zoom_scene.h"
#include "apps/viewer/play/picture_pace.h"
#include "core/result.h"

namespace floatstage::apps {

struct ZoomWindowOptions {
  std::string title;
  int width = 1280, height = 800;               ///< window, px
  std::size_t budget = std::size_t{512} << 20;  ///< bytes of video memory
  std::optional<Eigen::Vector2d> at;            ///< px of the root to begin at; absent: its middle
  double zoom = 0;                              ///< window px a root's px to begin with; 0: the whole
  bool fly = false;                             ///< go there from the whole, by 1 % a picture
  bool split = false, provenance = false, graph = false;
  std::filesystem::path screenshot;  ///< write the window to this PNG once it is there, then end
  std::function<bool()> stop;        ///< asked at every picture; absent: until the window is closed
};

/// What a window showed, for reports.
struct ZoomReport {
  PictureTimes pictures;       ///< of the window, with what was loaded for them
  double zoom = 0;             ///< window px a root's px at the end
  std::size_t allocated = 0;   ///< bytes of video memory for root and photographs
  double flat = 0;             ///< bytes of one texture that is everywhere as fine as the finest photograph
  double finest = 1;           ///< its pixels in one of the root, linear
  int layers = 0, passes = 0;  ///< photographs in video memory at once; passes of the last picture
  int steps = 0;               ///< pictures of the flight
};

/// The window that zooms into photographs. Returns when it is closed. Errors: those of Window::open() and
/// GlZipmap::make().
Result<ZoomReport> show_zoom(const ZoomScene& scene, const ZoomWindowOptions& options);

}  // namespace floatstage::apps
