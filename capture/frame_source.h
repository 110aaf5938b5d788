#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/camera_control.h"
#include "core/frame.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

/// What a started source will deliver.
struct StreamInfo {
  std::string name;                         ///< the camera's serial
  ImageLayout layout;                       ///< of every frame with a picture
  double frame_rate = 0;                    ///< nominal; 0 when unknown
  std::optional<std::int64_t> frame_count;  ///< for recordings: expected frames, gaps included
  bool ptp = false;                         ///< exposures are on the network's clock, not on the recorder's
};

/// Counters since start(). delivered + lost = expected.
struct SourceStats {
  std::uint64_t delivered = 0;  ///< frames handed out, corrupt ones included
  std::uint64_t lost = 0;       ///< gaps in the sequence
  std::uint64_t corrupt = 0;    ///< delivered with status Corrupt
  std::uint64_t starved =
      0;  ///< the device had no free buffer because the frames held elsewhere kept them all
  std::uint64_t failed = 0;  ///< of the lost: pictures that arrived in part and were thrown away
};

/// How a device says it is. What it does not say is absent.
struct DeviceHealth {
  std::optional<double> temperature_c;
};

/// The capture seam, complete. One thread calls start/next/stop; stats() may be called from any thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Allocates, then starts; never in the constructor. Starting a started source is refused
  /// (InvalidArgument). After stop() it may be started again, from the beginning.
  virtual Result<StreamInfo> start() = 0;
  /// The next frame. Timeout is an outcome; Disconnected is an error and final until stop() and start();
  /// EndOfStream says a recording is over. InvalidArgument when not started. Lost frames are not delivered:
  /// the sequence number jumps and stats().lost grows.
  virtual Result<Frame> next(Nanoseconds timeout) = 0;
  /// Frames held elsewhere stay valid. Stopping a stopped source does nothing.
  virtual void stop() = 0;
  virtual SourceStats stats() const = 0;
  /// Asks the device, which takes it a moment: from the thread that calls next(), while started.
  virtual DeviceHealth health() { return {}; }
  /// Exposure, gain and white balance, as far as the device lets them be set now; as health(). Empty where
  /// there are none.
  virtual std::vector<CameraControl> controls() { return {}; }
  /// Turns one of controls(), which holds until stop(); as health(). What was automatic about it is switched
  /// off (V4L2 tells such a control only once its automatic is off). NotFound for another name,
  /// InvalidArgument, with the range, for a value that the device refuses.
  virtual Result<void> set_control(const std::string& name, double /*value*/) {
    return fail(ErrorCode::NotFound, "this camera has no control '" + name + "'");
  }
  /// What start() and next() ask while they work or wait for long, from any of their threads: once it says
  /// yes they give up within a second (Cancelled). Before start(), or by the thread that calls next().
  void stop_when(std::function<bool()> stop) { stop_ = std::move(stop); }

 protected:
  bool stopped() const { return stop_ && stop_(); }

 private:
  std::function<bool()> stop_;
};

/// Opens a source by URI: "take:<folder>#<serial>", "synthetic:camera=3&cameras=8&seed=1&…".
/// Errors name the URI and what is understood.
Result<std::unique_ptr<FrameSource>> open_source(const std::string& uri);

}  // namespace floatstage::capture
