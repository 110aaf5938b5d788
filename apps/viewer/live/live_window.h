#pragma once

#include <filesystem>
#include <functional>

#include "apps/viewer/live/control_model.h"
#include "capture/stream/stream_output.h"
#include "studio/live/live_run.h"
#include "studio/live/scene_feed.h"

namespace floatstage::apps {

struct LiveWindowOptions {
  studio::LiveRunOptions run;  ///< `seconds` is how long it stays open; its size is the window's
  bool show_cameras = false;
  std::function<bool()> stop = nullptr;  ///< asked at every picture; absent: until the window is closed
  std::filesystem::path path_file;       ///< a camera path to follow
  std::filesystem::path screenshot;  ///< write the window to this PNG once a few scenes were shown, then end
  capture::StreamOutput* stream = nullptr;  ///< gets what the stage shows (its left side), where there is one
};

/// The operator's window on a live studio: what the player has (methods, comparison, intermediates, cameras,
/// paths), and the cameras' health, quality, and record and stop. Returns when it is closed.
Result<void> run_live_window(studio::SceneFeed& feed, ControlModel& model, const LiveWindowOptions& options);

}  // namespace floatstage::apps
