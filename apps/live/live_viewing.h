#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/live/live_stream.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/verb.h"
#include "pipeline/orbit.h"
#include "studio/live/live_run.h"
#include "studio/live/remote_scenes.h"
#include "studio/live/scene_feed.h"
#include "studio/messages/studio_control.h"

namespace floatstage::apps {

/// How scenes are looked at, the same for `live` and `live view`: in a window, or without one by a view that
/// walks around the stage.
struct LiveViewing {
  std::filesystem::path json, snapshots, path_file, screenshot;
  std::string background = "000000", back_end = "auto", alignment = "auto";
  Size size{0, 0};  ///< 0: as the view or the window has it
  bool headless = false, show_cameras = false;
  pipeline::OrbitOptions orbit{.seconds = 20};
  int blend = 3;
  StreamFlags stream;
  studio::LiveRunOptions run;
};

void add_viewing_flags(CLI::App& verb, LiveViewing& viewing);

/// Settles what hangs on other flags: the size, the renderer. InvalidArgument for flags that contradict one
/// another.
Result<void> settle(LiveViewing& viewing);

/// Shows scenes until `viewing` or the user says that it is enough. `network` is null for scenes of this
/// process; `nodes` are whose cameras the window watches and commands.
Result<void> view_scenes(studio::SceneFeed& feed, const studio::RemoteScenes* network,
                         std::vector<studio::StudioControl*> nodes, const LiveViewing& viewing);

}  // namespace floatstage::apps
