#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/rig.h"
#include "studio/live/scene_feed.h"
#include "studio/live/tile_join.h"
#include "studio/network/subscriber.h"

namespace floatstage::studio {

struct RemoteOptions {
  std::string recon;               ///< address of the machine that reconstructs
  std::vector<std::string> nodes;  ///< addresses of the capture nodes
  std::optional<wire::StudioKeys> keys;
  JoinOptions join;
};

/// The viewer's end of the network: scenes from the machine that reconstructs, textures from the capture
/// nodes, and of those only the cameras that the view needs. Owned by the thread that draws.
class RemoteScenes final : public SceneFeed {
 public:
  struct NetworkCounters {
    wire::SubscriberCounters network;
    TileJoin::Counters joined;
    std::uint64_t other_rig = 0;  ///< scenes that were made with another rig
  };

  /// Errors: those of Subscriber::connect().
  static Result<std::unique_ptr<RemoteScenes>> open(const Rig& rig, const RemoteOptions& options);

  /// The newest scene that was not handed out yet; waits for one until `deadline`, null then.
  std::shared_ptr<const LiveScene> newest(Timestamp deadline) override;
  /// Whose textures the next scenes hold: places in the rig. Until the first call nobody's travel.
  void want(const std::vector<int>& cameras) override;

  const Rig& rig() const override { return rig_; }
  std::string description() const override { return "scenes of " + recon_; }
  double frame_rate() const override { return frame_rate_; }  ///< of the scenes that come, smoothed
  Counters counters() const override;
  NetworkCounters network() const;
  std::string remark() const override { return remark_; }

 private:
  RemoteScenes(const Rig& rig, const RemoteOptions& options);
  void take(const wire::Received& received);
  void notice_silence(Timestamp time);

  const Rig rig_;
  const std::string recon_;
  const std::string digest_;
  TileJoin join_;
  std::unique_ptr<wire::Subscriber> subscriber_;
  std::uint64_t other_rig_ = 0;
  double frame_rate_ = 0;
  Timestamp last_instant_;
  Timestamp heard_;  // when the last scene came, or this began
  bool silent_ = false;
  std::string remark_;
};

}  // namespace floatstage::studio
