#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/time.h"
#include "studio/live/live_scene.h"

namespace floatstage::studio {

struct JoinOptions {
  Nanoseconds patience = milliseconds(150);  ///< of a scene with its tiles
  Nanoseconds silence = milliseconds(500);  ///< a camera whose last tile is that much older is not waited for
};

/// Puts scenes of one machine and tiles of others together: the newest scene of which every wanted texture
/// has come. A camera is waited for only while its tiles come at all, so that a viewer which turns, a subject
/// that leaves a picture, or a node that died never stop the view.
///
/// Owned by one thread. Time is a parameter.
class TileJoin {
 public:
  struct Counters {
    std::uint64_t scenes = 0, tiles = 0;  ///< that came
    std::uint64_t shown = 0;              ///< scenes handed out
    std::uint64_t incomplete = 0;         ///< of them: without a wanted texture
    std::uint64_t overtaken = 0;          ///< scenes that a newer one was handed out before
  };

  TileJoin(std::vector<std::string> serials, const JoinOptions& options);

  /// Places of the cameras whose textures matter.
  void want(std::set<int> cameras) { wanted_ = std::move(cameras); }
  void push(std::shared_ptr<const StudioScene> scene, Timestamp now);
  void push(std::shared_ptr<const CameraView> tile);

  /// The newest scene that is complete, or has waited long enough; null when there is none that is newer than
  /// the last.
  std::shared_ptr<LiveScene> newest(Timestamp now);
  const Counters& counters() const { return counters_; }

 private:
  struct Waiting {
    std::shared_ptr<const StudioScene> scene;
    Timestamp came;
  };
  const CameraView* tile_of(int camera, Timestamp exposed) const;
  bool is_ready(const Waiting& waiting, Timestamp now) const;
  std::shared_ptr<LiveScene> joined(const StudioScene& scene, Timestamp now);
  int place_of(const std::string& serial) const;

  const std::vector<std::string> serials_;
  const JoinOptions options_;
  std::set<int> wanted_;
  std::deque<Waiting> scenes_;                                        // oldest first
  std::vector<std::deque<std::shared_ptr<const CameraView>>> tiles_;  // per camera, oldest first
  Counters counters_;
};

}  // namespace floatstage::studio
