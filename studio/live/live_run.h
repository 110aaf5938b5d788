#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "studio/live/live_chain.h"
#include "studio/live/live_stats.h"
#include "studio/live/live_view.h"
#include "studio/live/scene_feed.h"

namespace floatstage::studio {

struct LiveRunOptions {
  double seconds = 0;  ///< of drawing; 0: until stopped or until the source is over
  int width = 640, height = 480;
  render::RendererOptions renderer;  ///< method and flow come from the quality
  std::size_t quality = 0;           ///< of live_qualities(), to begin with
  double target_fps =
      12;  ///< the quality is changed so that so many scenes a second are shown; 0: never changed
  double view_fps = 10;  ///< the view goes on so often when no new scene comes nor is being made
};

/// A picture as it leaves the chain.
struct LivePicture {
  Image picture;  ///< RGBA as the renderer leaves it; transparent where there is no subject
  View view;
  const LiveScene* scene;  ///< what it shows
  double seconds = 0;      ///< since the first
  bool again = false;      ///< the scene was shown before, from another view perhaps
};

struct QualityChange {
  double seconds;
  std::string quality;  ///< describe()
  double fps;           ///< that made it necessary or possible
};

/// What came to be said of the silhouettes, or no longer was.
struct SilhouetteChange {
  double seconds;
  std::shared_ptr<const SilhouetteNews> news;
};

struct LiveReport {
  double seconds = 0;    ///< from the first picture on
  Rate shown, pictures;  ///< scenes shown for the first time; all pictures
  Series latency;        ///< ms from the first picture's production until the view was drawn and read back
  std::vector<std::pair<std::string, Series>> stages;  ///< ms each, in the chain's order
  LiveChain::Counters counters;
  std::vector<QualityChange> qualities;  ///< the first is what it began with
  std::vector<SilhouetteChange> silhouettes;
};

/// Where the virtual camera is, `seconds` after the first picture.
using ViewAt = std::function<View(double seconds)>;

/// Draws scenes without a window, on the calling thread, where the renderer's back-end is open. The
/// first two seconds warm up and are not in the report. `visit` gets every picture; `stop` is asked between
/// them.
Result<LiveReport> run_live(SceneFeed& scenes, const LiveRunOptions& options, const ViewAt& view_at,
                            const std::function<bool()>& stop,
                            const std::function<Result<void>(const LivePicture&)>& visit);

/// The same with a chain of its own.
Result<LiveReport> run_live(LiveSource& source, const LiveChainOptions& chain, const LiveRunOptions& options,
                            const ViewAt& view_at, const std::function<bool()>& stop,
                            const std::function<Result<void>(const LivePicture&)>& visit);

}  // namespace floatstage::studio
