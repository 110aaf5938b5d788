#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "core/reused.h"
#include "studio/live/live_quality.h"
#include "studio/live/live_scene.h"
#include "studio/live/live_source.h"
#include "studio/live/reconstruction.h"
#include "studio/live/scene_feed.h"
#include "studio/live/silhouette_watch.h"
#include "studio/node/camera_rack.h"

namespace floatstage::studio {

struct LiveChainOptions {
  std::string key = "auto";                     ///< keyer spec, or each camera's own
  Nanoseconds tolerance = milliseconds(4);      ///< of the exposures of one instant
  Nanoseconds longest_wait = milliseconds(30);  ///< for a camera that is late
  int threads = 0;                              ///< of one stage; 0: one per core
};

/// Cameras in, scenes out, in one process: frames are grouped by instant, keyed by the camera nodes, and made
/// into a surface on one thread of the chain (which uses all cores), while the caller draws the scene before.
///
/// Work is done on demand: the chain begins with the newest instant so that its scene is ready when the view
/// has drawn the last one, and instants that come in between are left out and counted. Nothing waits in line,
/// so pictures are as young as the machine allows, and no work is done for scenes that nobody would see.
/// Scenes and what they hold are used again once they were dropped: a warm chain allocates nothing for them.
class LiveChain final : public SceneFeed {
 public:
  /// The source outlives the chain. Errors: a keyer that cannot be made, the synchroniser's options.
  static Result<std::unique_ptr<LiveChain>> make(LiveSource& source, const LiveChainOptions& options);
  ~LiveChain() override { end(); }

  void begin();
  void end() override;

  /// The newest scene that was not handed out yet; waits for one until `deadline`. Null then, and when the
  /// source is over and everything was handed out.
  std::shared_ptr<const LiveScene> newest(Timestamp deadline) override;
  /// The source is over and every scene was handed out.
  bool over() const override;
  /// The view draws, so that the next scene may be ready when it is done. Any time may be left out.
  void drawing(Timestamp begun) override;
  void drawn(Timestamp ended) override;
  /// Whose textures the next scenes hold; until the first call: everybody's.
  void want(const std::vector<int>& cameras) override;
  bool working() const override;
  void set_quality(const NodeQuality& quality) override;

  const Rig& rig() const override { return source_.rig(); }
  std::string description() const override;
  double frame_rate() const override { return source_.frame_rate(); }
  void poll() override { source_.poll(); }
  StudioControl* control() override { return source_.control(); }
  LiveSource& source() { return source_; }
  Counters counters() const override;
  std::string remark() const override;  ///< what is wrong with the scene at present; empty when nothing is
  std::shared_ptr<const SilhouetteNews> silhouettes() const override { return watch_.news(); }

 private:
  LiveChain(LiveSource& source, const LiveChainOptions& options, CameraRack rack,
            std::unique_ptr<SetBuilder> sets)
      : source_(source),
        options_(options),
        rack_(std::move(rack)),
        keys_(rack_.keys()),
        sets_(std::move(sets)),
        reconstruction_(source.rig(), ""),
        watch_(source.rig(), keys_) {}
  void run();
  bool wait_for_demand();
  void make_scene(const TimedSet& set);
  Timestamp start_of_work() const;  // under mutex_
  void set_remark(const std::string& remark);

  LiveSource& source_;
  const LiveChainOptions options_;
  CameraRack rack_;  // the chain's thread only
  const std::string keys_;
  std::unique_ptr<SetBuilder> sets_;
  Reconstruction reconstruction_;
  SilhouetteWatch watch_;
  Reused<LiveScene> scenes_;
  std::vector<bool> textured_now_;  // of the scene in work
  std::thread thread_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const LiveScene> next_;
  std::vector<bool> textured_;
  NodeQuality quality_;
  std::optional<Timestamp> drawing_since_;
  double draws_ms_ = 0, makes_ms_ = 0;  // what the last ones took, smoothed
  Counters counters_;
  std::string remark_;
  bool stopping_ = false, over_ = false, working_ = false;
};

}  // namespace floatstage::studio
