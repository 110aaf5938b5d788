#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/rig.h"
#include "studio/live/live_scene.h"
#include "studio/live/silhouette_watch.h"
#include "studio/messages/studio_control.h"
#include "studio/node/camera_view_maker.h"
#include "studio/node/set_builder.h"

namespace floatstage::studio {

/// Where a live view gets its scenes: from a chain in this process (LiveChain), or from other machines
/// (RemoteScenes). Owned by the thread that draws.
class SceneFeed {
 public:
  struct Counters {
    SetBuilder::Counters sets;
    std::uint64_t scenes = 0;    ///< made, or come
    std::uint64_t unseen = 0;    ///< of them: overtaken by a newer one before the view had time
    std::uint64_t troubled = 0;  ///< instants in which a camera's picture could not be used
    std::uint64_t failed = 0;    ///< instants without a scene
    double busy_seconds = 0;
  };

  virtual ~SceneFeed() = default;
  virtual const Rig& rig() const = 0;
  virtual std::string description() const = 0;  ///< what is seen, for people
  virtual double frame_rate() const = 0;        ///< instants a second that there could be
  /// The newest scene that was not handed out yet; waits for one until `deadline`. Null then, and when there
  /// will be none.
  virtual std::shared_ptr<const LiveScene> newest(Timestamp deadline) = 0;
  /// Whose textures the next scenes hold: places in the rig.
  virtual void want(const std::vector<int>& cameras) = 0;
  /// The view draws, so that the next scene may be ready when it is done. Any time may be left out.
  virtual void drawing(Timestamp /*begun*/) {}
  virtual void drawn(Timestamp /*ended*/) {}
  /// Whether a scene is being made on this machine, which pictures of the last one would only delay.
  virtual bool working() const { return false; }
  virtual void set_quality(const NodeQuality& /*quality*/) {}
  virtual void poll() {}  ///< called between pictures
  /// Health of the cameras, and takes; the feed's own. Null where there is nothing to ask.
  virtual StudioControl* control() { return nullptr; }
  virtual bool over() const { return false; }
  virtual void end() {}
  virtual Counters counters() const = 0;
  /// What is wrong with the cameras' silhouettes; null where they are judged on another machine.
  virtual std::shared_ptr<const SilhouetteNews> silhouettes() const { return nullptr; }
  virtual std::string remark() const = 0;  ///< what is wrong with the scene at present; empty when nothing is
};

}  // namespace floatstage::studio
