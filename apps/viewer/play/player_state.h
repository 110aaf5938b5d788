#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/viewer/play/path_editor.h"
#include "apps/viewer/play/viewer_camera.h"
#include "apps/viewer/window/time_line.h"
#include "render/renderer.h"

namespace floatstage::apps {

/// Everything that the operator can change, without a window: panels write it, the canvas reads it.
struct PlayerState {
  TimeLine time;
  ViewerCamera camera;
  PathEditor path = {};
  pipeline::SubjectTrack track = {};  ///< what keys that follow are seen from; empty: none can
  bool keys_hold_take = false;        ///< new keys say which frame of the take they show

  std::vector<std::string> methods = {};  ///< every renderer's name
  int left = 0, right = 0;                ///< methods shown; `right` only when split
  bool split = false;
  std::optional<render::RenderOutput> right_output = {};  ///< what the right side shows; absent: as the left
  std::vector<std::string> serials = {};                  ///< of the cameras, whose photographs can be shown
  /// Splits, or no longer: a first split compares linear with floating, and the method from before comes
  /// back.
  void toggle_split();
  int alone = 0;          ///< the method from before the split
  float split_at = 0.5f;  ///< where the picture changes from left to right, 0…1
  render::RendererOptions renderer = {};
  float render_scale = 1;  ///< pixels rendered per pixel shown, 0.25…1
  bool quick = false;      ///< coarser while something moves (PicturePace)

  struct Who {
    std::string label;
    bool shown = true;
  };
  std::vector<Who> who = {};  ///< the take's labels, and which of them are to be seen

  std::vector<std::string> sounds = {};  ///< names of the take's tracks that can be heard
  int sound = 0;                         ///< which one is
  float volume = 1;
  bool muted = false;

  bool show_cameras = false;
  bool show_times = false;   ///< of the stages, in a corner
  bool follow_path = false;  ///< the camera rides the path instead of the mouse
  double path_time = 0;      ///< seconds
  /// A key where the camera is, after the last.
  void add_key();
  /// The take shows what the film shows at path_time.
  void seek_by_path();

  std::string path_file = "path.json", film_file = "path.mp4";
  std::string status = {};  ///< one line at the bottom: the last thing that happened
};

}  // namespace floatstage::apps
