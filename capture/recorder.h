#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "capture/time_offsets.h"
#include "core/bounded_queue.h"
#include "core/frame.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::capture {

/// What a recording must keep to, from the studio's configuration.
struct RecordingLimits {
  std::uint64_t skips = 0;       ///< frames of any camera that never came
  std::uint64_t duplicates = 0;  ///< frames of any camera for an instant that it had already
  double spread_ms = 1;          ///< of the exposures of one instant
  double rate_deviation = 0.01;  ///< |measured / nominal - 1| of any camera
};

struct RecorderOptions {
  TakeWriterOptions take;  ///< take.frame_rate > 0: the cameras' nominal common rate
  /// The instant of row 0; absent: that of the first frame pushed.
  std::optional<Timestamp> origin;
  std::size_t queue_frames =
      64;  ///< of a camera, between its thread and the disk; a full queue blocks (Block)
  RecordingLimits limits;
  /// How far stamps are from instants: pictures find their rows, and are judged, by instants. Stamps are
  /// recorded as they are, and what is known of them lies in the take beside them (times.json).
  TimeOffsetFile times = {};
  /// The disk is made to keep what was written so often (DiskSync): a power cut takes no more. 0: when the
  /// system likes, which is half a minute.
  double sync_seconds = 0;
};

/// One camera of a recording, so far.
struct RecordedCamera {
  std::string serial;
  std::uint64_t recorded = 0;  ///< pictures
  std::uint64_t skips = 0;     ///< rows without one: the gaps of its side file
  /// Of the skips: the camera counts none there, so it never exposed (a trigger that it missed, an unplugged
  /// cable). Counts are compared from its first picture here to its last: a picture that came so late that
  /// it stands in the next row left one row empty and is no picture more.
  std::uint64_t unexposed = 0;
  /// Pictures that the camera counts from its first one here to its last, and that never came.
  std::uint64_t lost = 0;
  /// Of the lost: what the source received in part.
  std::uint64_t failed = 0;
  std::uint64_t duplicates = 0;  ///< left out, because their row had a picture
  std::uint64_t corrupt = 0;
  double frame_rate = 0;       ///< measured over its exposures; 0 with fewer than two
  std::size_t queue_peak = 0;  ///< most pictures that waited for the disk
};

struct RecordingQuality {
  std::vector<RecordedCamera> cameras;  ///< in the rig's order
  double spread_p50_ms = 0, spread_max_ms = 0;
  std::vector<std::string> complaints;  ///< one sentence for each limit that was passed; empty: PASS
  bool pass() const { return complaints.empty(); }
};

/// {"verdict", "cameras": [{"serial", "recorded", "skips", …}], "spread_ms": {"p50", "max"}, "complaints"}:
/// what quality.json holds.
std::string to_json(const RecordingQuality& quality);

/// A frame with pixels of its own: what keeps it does not keep the camera's buffer.
Frame detached(const Frame& frame);

/// Writes what several cameras deliver into a take, and judges it while it grows.
///
/// Rows are instants of one grid over all cameras, which follows their exposures (EpochGrid): a frame finds
/// its row by its time, and by its camera's count where both agree. What no picture came for is a row that
/// says so, and all cameras have equally many rows. Frames of instants before row 0 are left out.
///
/// push() may be called from one thread a camera. The picture is copied into a queue of its camera, so a slow
/// disk costs memory up to `queue_frames` and then makes push() wait; it never starves the camera of its
/// buffers.
class Recorder {
 public:
  /// Errors: those of TakeWriter::create(), and InvalidArgument without a frame rate.
  static Result<std::unique_ptr<Recorder>> start(const std::filesystem::path& folder, const Rig& rig,
                                                 const RecorderOptions& options);
  virtual ~Recorder() = default;
  /// Takes a frame; frame.info.camera is its place in the rig. An error is that camera's alone and final: the
  /// disk (Io), or a frame that does not fit the rig (InvalidArgument).
  /// `failed` is the source's count of failed pictures at that moment, summed over its connections.
  virtual Result<void> push(const Frame& frame, std::uint64_t failed = 0) = 0;
  /// The camera was stopped and started: its numbers begin anew, and its next frame finds its row by its
  /// time. From the thread that pushes its frames.
  virtual void restarted(int camera) = 0;
  /// From any thread, while it grows.
  virtual RecordingQuality quality() const = 0;
  /// Writes the verdict so far into quality.json. Io.
  virtual Result<void> save_quality() const = 0;
  /// The take shall end at the first instant from `time` on that every camera has a picture of, so that no
  /// camera ends in gaps because another one was faster. Frames go on being pushed meanwhile. From any
  /// thread.
  virtual void end_at(Timestamp time) = 0;
  /// That instant was found: nothing more is needed. Where it is not to be expected (a camera is gone), don't
  /// wait for it long.
  virtual bool ended() const = 0;
  /// Waits until everything is on disk, closes the take and writes its quality.json. The first error of any
  /// camera when there was one; what was written stays.
  virtual Result<RecordingQuality> finish() = 0;
};

}  // namespace floatstage::capture
