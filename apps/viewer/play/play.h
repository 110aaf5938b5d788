#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/viewer/mattes/matte_picture.h"
#include "apps/viewer/play/canvas.h"
#include "apps/viewer/play/sound_lead.h"
#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "render/renderer.h"

namespace floatstage::apps {

struct PlayOptions {
  std::filesystem::path take;
  pipeline::LabelChoice labels = {};  ///< who of it is seen first
  std::string method = "floating";
  std::string compare;  ///< method of the right half; empty: no split
  int frame = 0;
  bool show_cameras = false, playing = false;
  std::filesystem::path path_file;   ///< camera path to begin with; empty: none
  int width = 1280, height = 800;    ///< window, px
  std::filesystem::path screenshot;  ///< write the window to this PNG once the picture stands, then end
  render::RendererOptions renderer = {};
  bool sound = true;                          ///< is heard where the take has some
  std::string track;                          ///< of its sound, first heard; empty: the first
  std::string sound_output = "alsa:default";  ///< capture::open_sound_output()
  bool balance = false;                       ///< cameras' colours are brought to one another
  std::function<bool()> stop;                 ///< asked at every picture; absent: until the window is closed

  bool mattes = false;  ///< begin in the matte editor, which needs no meshes
  std::string camera;   ///< whose mattes; empty: the rig's first
  MatteView view = MatteView::Checker;
  std::string matte;            ///< as in `matte`; empty: as the mattes were made
  std::filesystem::path guide;  ///< as in `matte`; used with a way
  bool automatic = true;        ///< the editor makes mattes after every edit
};

/// What a window showed and how quickly, for reports.
struct PlayReport {
  CanvasTimes pictures;
  /// From an input, at the latest that it can have come, to the window that shows the first picture with it.
  PictureTimes after_input;
  int frame = 0;                            ///< that it showed last
  long events = 0;                          ///< of hands
  long keys = 0, presses = 0;               ///< of them: keys, those that repeat left out; buttons
  std::string renderer;                     ///< what drew
  std::vector<ShownWhileHeard> heard = {};  ///< the first pictures that were shown while sound was heard
};

/// The window: the interactive player on a processed take, and the matte editor. Returns when it is closed.
Result<PlayReport> play_take(const PlayOptions& options);

}  // namespace floatstage::apps
