#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "capture/take.h"
#include "studio/live/live_source.h"

namespace floatstage::studio {

struct TakePlayerOptions {
  double rate = 0;    ///< instants a second; 0: as recorded
  bool loop = false;  ///< begins anew when it is over, as if the subject did it all again
  /// A take whose pictures fit is decoded before it is played: real cameras deliver pictures, they do not
  /// decode them. A larger one is decoded while it plays, one instant ahead, which costs the chain what
  /// decoding costs.
  std::uint64_t preload_bytes = 4'000'000'000;
  std::function<bool()> stop = {};  ///< asked while that lasts, from several threads
};

/// A take, played as if its cameras were delivering it now: at its own pace, each frame at the time of its
/// exposure, exposure times moved to the present; where its times.json knows the instants better than its
/// stamps do, they are told by time_offsets(). What was lost when it was recorded is not delivered.
class TakePlayer final : public LiveSource {
 public:
  /// Errors: those of TakeReader::open() and load_time_offsets(); Cancelled; InvalidArgument for a take of no
  /// rate when none is given, and of no frames.
  static Result<std::unique_ptr<TakePlayer>> open(const std::filesystem::path& folder,
                                                  const TakePlayerOptions& options);
  ~TakePlayer() override { stop(); }

  const Rig& rig() const override { return take_->rig(); }
  double frame_rate() const override { return rate_; }
  std::vector<Nanoseconds> time_offsets() const override { return offsets_; }
  std::vector<matting::KeySamples> samples() const override { return samples_; }
  std::string description() const override;
  void begin(Tap tap) override;
  bool over() const override;
  void stop() override;

  capture::TakeReader& take() { return *take_; }
  int rows() const { return take_->frame_count(); }

 private:
  TakePlayer(std::unique_ptr<capture::TakeReader> take, const TakePlayerOptions& options)
      : take_(std::move(take)), options_(options) {}
  Result<void> load_samples();
  Result<void> preload();
  std::vector<Frame> row(int index);
  void run(const Tap& tap);
  bool sleep_until(Timestamp time);

  const std::unique_ptr<capture::TakeReader> take_;
  const TakePlayerOptions options_;
  double rate_ = 0, speed_ = 1;
  std::vector<Nanoseconds> offsets_;           // per camera, at the player's speed
  std::vector<Timestamp> times_;               // of the rows: the earliest exposure
  std::vector<matting::KeySamples> samples_;   // per camera
  std::vector<std::vector<Frame>> preloaded_;  // per row and camera; empty when decoded while playing
  std::thread thread_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false, over_ = false;
};

}  // namespace floatstage::studio
