#pragma once

#include <filesystem>
#include <functional>

#include "apps/viewer/calibration/calibration_run.h"

namespace floatstage::apps {

struct LiveViewOptions {
  int width = 1280, height = 800;    ///< px
  std::filesystem::path screenshot;  ///< write the window to this PNG when the pictures are over, then end
};

/// Shows a run in a window until it is closed: per camera what has been seen where and how well it is solved,
/// what joins the cameras, and what to show next. Main thread only.
Result<void> show_live(LiveRun& run, const LiveViewOptions& options,
                       const std::function<bool()>& interrupted);

/// The same in a few lines of text, for a terminal.
std::string describe_live(const LiveStatus& status);

}  // namespace floatstage::apps
