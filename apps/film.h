#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/camera_path.h"
#include "capture/take.h"
#include "core/result.h"
#include "render/renderer.h"

namespace floatstage {

struct FilmOptions {
  std::filesystem::path out;  ///< "*.mp4", "*.mkv" or "*.mov": H.264 video; anything else: a new folder of PNGs
  int width = 640, height = 480;
  double frame_rate = 25;            ///< of the film
  double seconds = 0;                ///< length; 0: the take's own, or the path's when the take is one instant
  std::vector<int> frames;           ///< frames of the take to play, in order; begun again when the film is longer
  std::vector<std::string> methods;  ///< more than one: side by side
  bool suppress_spill = true;
  RendererOptions renderer;
};

struct FilmReport {
  int pictures = 0;
  double seconds = 0;        ///< that rendering took
  double render_seconds = 0;  ///< of it in the renderers
};

/// Walks the virtual camera along `path` while the take plays. The file appears under its name only when it is whole;
/// an existing one is not overwritten. Needs a current GL context.
Result<FilmReport> render_film(TakeReader& take, const CameraPath& path, const FilmOptions& options);

}  // namespace floatstage
