#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "capture/frame_source.h"
#include "studio/messages/studio_control.h"
#include "studio/node/capture_config.h"

namespace floatstage::studio {

/// One camera of a node and the thread that reads it. A camera that is unplugged is started again until the
/// lane is stopped.
class CameraLane {
 public:
  /// What becomes of its frames, on the lane's thread. `failed`: its source's count of failed pictures at
  /// that moment, over all connections.
  struct Sink {
    std::function<void(const Frame& frame, std::uint64_t failed)> frame;
    std::function<void()> restarted;  ///< its numbers begin anew
  };

  /// Opens and starts the camera; Cancelled once `stop` says yes meanwhile. Errors: those of open_source()
  /// and FrameSource::start().
  static Result<std::unique_ptr<CameraLane>> open(const CaptureConfig::Camera& camera, int index,
                                                  const std::function<bool()>& stop = {});
  ~CameraLane() { stop(); }

  const capture::StreamInfo& info() const { return info_; }
  const std::string& serial() const { return camera_.serial; }
  void begin(Sink sink);
  /// Returns when its thread has ended.
  void stop();
  /// Its recording is over, or it was stopped.
  bool over() const;
  NodeCamera status() const;
  /// As they were read last: when somebody asked before, after a knob was turned, or at the start. Waits for
  /// nothing; who asks again half a second later hears how they are.
  std::vector<capture::CameraControl> controls() const;
  /// Has the lane's thread set it, and waits for that, 3 s at most. Set again when the camera was unplugged.
  Result<void> set_control(const std::string& name, double value);
  /// Over the whole session, unlike the status'.
  double mean_frame_rate() const;
  std::optional<Timestamp> newest() const;
  /// Now, on the clock of its pictures, earlier by what they take to arrive; nothing before the first one.
  std::optional<Timestamp> now() const;
  /// When its thread last said that it lives. One that hangs in a driver does not.
  std::chrono::steady_clock::time_point alive() const;

 private:
  CameraLane(CaptureConfig::Camera camera, int index) : camera_(std::move(camera)), index_(index) {}
  void run();
  void take(Frame frame);
  void nothing_came();
  bool reconnect();
  void ask_health();
  void turn_knobs();
  struct Knob {
    std::string name;
    double value = 0;
    std::optional<Result<void>> done;  // under mutex_
  };
  capture::SourceStats stats() const;  // under mutex_

  const CaptureConfig::Camera camera_;
  const int index_;
  std::unique_ptr<capture::FrameSource> source_;
  capture::StreamInfo info_;
  Sink sink_;
  std::thread thread_;
  std::atomic<bool> stopping_{false};
  std::condition_variable wake_;

  mutable std::mutex mutex_;     // over what follows
  capture::SourceStats before_;  // of the connections that ended
  std::uint64_t reconnects_ = 0, frames_ = 0;
  std::optional<Timestamp> first_, last_;
  std::deque<Timestamp> recent_;
  std::optional<double> temperature_c_;
  std::vector<capture::CameraControl> controls_;
  mutable bool controls_asked_ = false;
  std::chrono::steady_clock::time_point controls_read_;
  std::deque<std::shared_ptr<Knob>> knobs_;  // to be turned
  std::map<std::string, double> turned_;     // by hand, in this session
  std::string trouble_;
  bool over_ = false;
  std::chrono::steady_clock::time_point last_frame_, alive_, asked_;
};

}  // namespace floatstage::studio
