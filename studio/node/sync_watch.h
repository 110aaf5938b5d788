#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "capture/synchronizer.h"
#include "core/result.h"

namespace floatstage::studio {

/// Watches how well a node's cameras agree, in windows of some seconds: what its page shows, and what is
/// asked before a take begins. Looks at the frames' facts and keeps no picture. Safe from any thread.
class SyncWatch {
 public:
  /// `offsets`: SyncOptions::offsets. Errors: those of Synchronizer::make().
  static Result<std::unique_ptr<SyncWatch>> make(std::vector<std::string> serials, double frame_rate,
                                                 const capture::SyncLimits& limits,
                                                 std::vector<Nanoseconds> offsets = {});

  void push(const FrameInfo& info);
  /// Settles what is due, and begins a new window where the last one is full.
  void look(Timestamp now);

  struct Seen {
    double spread_p50_ms = 0, spread_max_ms = 0;
    std::vector<std::string> complaints;
    bool any = false;  ///< a whole window has been seen
  };
  Seen last() const;

 private:
  SyncWatch(std::vector<std::string> serials, const capture::SyncLimits& limits,
            capture::Synchronizer synchronizer);

  const std::vector<std::string> serials_;
  const capture::SyncLimits limits_;
  // A synchroniser takes frames that have a picture: this one's are a byte.
  const std::shared_ptr<const std::byte[]> picture_ = std::make_shared<std::byte[]>(1);
  mutable std::mutex mutex_;
  capture::Synchronizer synchronizer_;
  Timestamp begun_;
  bool settled_ = false;  // the first window is the one in which the cameras are started
  Seen seen_;
};

}  // namespace floatstage::studio
