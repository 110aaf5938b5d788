#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "calib/live_calibration.h"
#include "core/bounded_queue.h"
#include "core/result.h"
#include "studio/node/capture_config.h"

namespace floatstage::apps {

struct LiveOptions {
  calib::LiveTarget target;
  calib::CalibrationOptions calibration;
  calib::CoverageGoals goals;
  int solve_every = 20;             ///< sets that counted, between two quick solutions
  int quick_frames = 60;            ///< of a quick solution
  double seconds = 0;               ///< of streaming; 0: until stopped, or until every recording is over
  std::function<bool()> stop = {};  ///< asked while cameras start, from several threads
};

/// What an operator is shown.
struct LiveStatus {
  std::vector<std::string> serials;
  std::vector<std::pair<int, int>> sizes;  ///< px, of each camera's picture
  calib::LiveInstant instant;              ///< the latest
  calib::Coverage coverage;
  std::vector<calib::Advice> advice;
  double completeness = 0;
  int sets = 0, counted = 0;
  std::uint64_t passed_over =
      0;  ///< frames that came faster than they could be looked at (live cameras only)
  std::optional<calib::Calibration> solution;  ///< the latest quick one
  int solution_sets = 0;                       ///< how many sets counted when it began
  std::string trouble;                         ///< why there is no solution yet, or what a camera said
  bool over = false;                           ///< no more pictures come
  bool settled = false;                        ///< and the last quick solution is made
};

/// The solver on a running capture: one thread a camera, one that looks at sets, one that solves now and
/// then. Recordings
/// ("take:…") are looked at picture by picture, as fast as that goes; live cameras show their newest.
class LiveRun {
 public:
  /// Opens all sources. Errors of open_source() and start(); what is known beforehand is of `known`, by
  /// serial.
  static Result<std::unique_ptr<LiveRun>> start(const studio::CaptureConfig& config,
                                                const LiveOptions& options,
                                                const std::function<void(calib::Observations&)>& known);
  ~LiveRun();

  LiveStatus status() const;
  /// Until the pictures are over and the last quick solution is made.
  void wait() const;
  /// Ends the streams and joins all threads. Then observations() is all that counted.
  void stop();
  /// The error that ended the run, if one did.
  Result<void> outcome() const;
  calib::Observations observations() const;
  /// The target lies on the floor in the latest set that counted: its frame becomes the world.
  void set_floor(double height);

 private:
  LiveRun(const studio::CaptureConfig& config, const LiveOptions& options);
  void stream(std::size_t camera);
  void look();
  void solve();
  bool use(const FrameSet& set);
  void end_with(const Error& error);

  struct Lane;
  const studio::CaptureConfig config_;
  std::vector<Nanoseconds> offsets_;  // capture::SyncOptions::offsets
  const LiveOptions options_;
  std::vector<std::unique_ptr<Lane>> lanes_;
  std::unique_ptr<calib::LiveCalibration>
      live_;  // looking is of the looking thread; what is kept is under mutex_
  std::thread looking_, solving_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;
  mutable std::condition_variable wake_;
  LiveStatus status_;
  Result<void> outcome_;
};

}  // namespace floatstage::apps
