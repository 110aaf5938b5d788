#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "capture/synchronizer.h"
#include "studio/node/camera_view_maker.h"

namespace floatstage::studio {

/// What all cameras saw at one instant, and when their pictures were produced.
struct TimedSet {
  Instant instant;
  FrameSet images;
  std::vector<Timestamp> produced;  ///< per camera; only of those with a frame
  Timestamp first_produced;         ///< of the frames there are: latency counts from here
};

/// Frames from the cameras' threads in, the newest whole instant out. Instants that nobody fetched in time
/// are left out and counted: what is shown live is never old.
class SetBuilder {
 public:
  struct Counters {
    std::uint64_t frames = 0;     ///< pushed
    std::uint64_t sets = 0;       ///< instants that were ready
    std::uint64_t overtaken = 0;  ///< of them: a newer one was ready before anybody had time
    capture::SyncStats sync;
  };

  static Result<std::unique_ptr<SetBuilder>> make(int cameras, const capture::SyncOptions& options);

  /// From any thread; those of one camera one after the other.
  void push(const Frame& frame, Timestamp produced);
  /// The newest instant that is ready. Waits until `deadline` for one; nothing then, or after close().
  std::optional<TimedSet> newest(Timestamp deadline);
  void close();
  Counters counters() const;

 private:
  SetBuilder(capture::Synchronizer sync, std::size_t cameras, double frame_rate)
      : sync_(std::move(sync)), delivered_(cameras), period_(1e9 / frame_rate) {}
  void settle(Timestamp now);
  TimedSet timed(FrameSet set);

  struct Delivery {
    Timestamp exposed, produced;
  };
  mutable std::mutex mutex_;
  std::condition_variable ready_;
  capture::Synchronizer sync_;
  std::vector<std::deque<Delivery>> delivered_;  // per camera: frames that are in no set yet
  const double period_;                          // ns
  std::optional<Timestamp> first_;
  std::optional<TimedSet> newest_;
  Counters counters_;
  bool closed_ = false;
};

}  // namespace floatstage::studio
