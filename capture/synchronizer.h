#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "capture/spreads.h"
#include "core/frame.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

struct SyncOptions {
  double frame_rate = 0;                    ///< nominal, of all cameras; > 0
  Nanoseconds tolerance = milliseconds(4);  ///< a frame further from its set's middle is not of that instant
  Nanoseconds longest_wait = milliseconds(100);  ///< for a late camera, after the instant; then it is missing
  /// By camera, what its stamps lack to the instants at which it exposes (capture/time_offsets.h). Empty:
  /// none. Frames keep their stamps; sets are formed, timed and judged by instants.
  std::vector<Nanoseconds> offsets = {};
};

/// One camera in the sets so far.
struct CameraSync {
  std::uint64_t used = 0;              ///< frames that went out in a set
  std::uint64_t missing = 0;           ///< sets without it
  std::uint64_t late = 0;              ///< frames that came after their set had gone
  std::uint64_t out_of_tolerance = 0;  ///< frames near an instant, and not near enough
  std::uint64_t duplicates = 0;        ///< a second frame of one instant
  double mean_offset_ms = 0;           ///< from the middle of the sets, out-of-tolerance frames included
};

struct SyncStats {
  std::uint64_t complete = 0, incomplete = 0;  ///< sets that went out
  std::uint64_t skipped = 0;                   ///< instants that no camera saw
  /// Last - first exposure in a set, as Spreads tells it: the largest is exact.
  double spread_p50_ms = 0, spread_p99_ms = 0, spread_max_ms = 0;
  std::vector<CameraSync> cameras;
};

/// Groups the frames of several cameras by the instant of their exposure, on the epochs of a common clock and
/// never by the order of arrival: which frames make a set depends only on their times, so any interleaving of
/// the cameras gives the same sets, unless a camera is later than the longest wait.
///
/// The epochs are a loop that follows the cameras: phase and period are corrected after each set (an
/// alpha-beta filter), so that 29.97 against 30 frames a second never slips by a frame. An instant is settled
/// when every camera has shown a frame of it or of a later one, or when it is `longest_wait` old.
///
/// Owned by one thread. Time is a parameter. Frames of one camera come in order; one that goes back is late.
class Synchronizer {
 public:
  /// Errors: InvalidArgument for no camera, a rate that is not positive, or a tolerance of half a period or
  /// more, or offsets of another number of cameras.
  static Result<Synchronizer> make(int cameras, const SyncOptions& options);

  /// Takes a frame; frame.info.camera is its index. Lost frames belong to no set.
  void push(Frame frame);

  /// The next set that is settled at `now`; nothing when none is. Sets come in the order of time.
  std::optional<FrameSet> next(Timestamp now);

  /// As next(), with nothing more to wait for: at the end of a recording.
  std::optional<FrameSet> drain();

  SyncStats stats() const;

  /// stats(), which then count from zero: the loop goes on. For windows of a stream without end.
  SyncStats take_stats();

 private:
  Synchronizer(int cameras, const SyncOptions& options);

  enum class Wait { UntilLate, NotAtAll };
  std::optional<FrameSet> settle(Timestamp now, Wait wait);
  bool is_settled(Timestamp now, Wait wait) const;
  bool begin(Timestamp now, Wait wait);
  void skip_empty_instants();
  FrameSet take_set();
  void follow(double middle);
  std::int64_t instant_of(const Frame& frame) const;  // ns
  double half_period() const { return 0.5 * period_; }

  struct Lane {
    std::deque<Frame> waiting;
    CameraSync counts;
    double offsets_ns = 0;  // sum over `measured` frames
    std::uint64_t measured = 0;
  };

  SyncOptions options_;
  double nominal_period_ = 0, period_ = 0;  // ns
  bool begun_ = false;
  std::int64_t base_ = 0;  // ns; expected_ counts from here so that doubles keep nanoseconds
  double expected_ = 0;    // ns after base_: the instant of the next set
  double gone_ = 0;        // frames before this (ns after base_) are late
  std::vector<Lane> lanes_;
  Spreads spreads_;
  SyncStats totals_;
};

/// Bars of a take, from the studio's configuration.
struct SyncLimits {
  double spread_ms = 1;              ///< largest spread of a set
  std::uint64_t missing_frames = 0;  ///< of any camera
};

/// Says before a take what is wrong with the cameras' agreement, one sentence each that names the camera;
/// empty when the limits hold. `serials` are in the order of the frames' indices.
std::vector<std::string> sync_complaints(const SyncStats& stats, const std::vector<std::string>& serials,
                                         const SyncLimits& limits);

}  // namespace floatstage::capture
