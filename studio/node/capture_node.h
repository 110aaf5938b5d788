#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "capture/recorder.h"
#include "capture/sound/sound_source.h"
#include "studio/messages/studio_control.h"
#include "studio/node/camera_lane.h"
#include "studio/node/capture_config.h"
#include "studio/node/pre_roll.h"
#include "studio/node/sync_watch.h"
#include "studio/node/take_sealer.h"

namespace floatstage::studio {

/// A camera node: all cameras of a config, each on a thread of its own, and takes that are begun and ended by
/// StudioControl. Whatever goes wrong with one camera or with one take leaves the rest running.
class CaptureNode final : public StudioControl {
 public:
  /// A look at every frame on its camera's thread (previews, keying): it must not wait. frame.info.camera is
  /// the place in the config.
  using Tap = std::function<void(const Frame&)>;

  /// Starts the cameras one after the other. Errors: a URI, or a camera that does not start. Fewer than all
  /// is no session: fix or remove it. Cancelled once `stop`, which is asked from several threads, says yes.
  static Result<std::unique_ptr<CaptureNode>> open(CaptureConfig config,
                                                   const std::function<bool()>& stop = {});
  ~CaptureNode() override;

  /// Before begin().
  void add_tap(Tap tap) { taps_.push_back(std::move(tap)); }
  void begin();
  /// To be called about ten times a second: keeps the verdict of a take on disk, ends it before the disk is
  /// full or where it has failed, and watches the cameras' agreement.
  void poll();
  /// Every camera's recording is over (never, for cameras that are no recordings).
  bool over() const;
  /// All cameras' threads live.
  bool alive() const;

  /// As start_recording(), with the take's folder chosen; empty: named by the time, in the config's folder.
  Result<std::string> record_into(std::filesystem::path folder, const std::string& label);
  /// Until the takes of this node are sealed, which goes on beside everything else while none is recorded;
  /// false once `stop` has answered yes.
  bool wait_for_seals(const std::function<bool()>& stop) { return sealer_.wait(stop); }
  /// Ends the take, if there is one, and the cameras.
  Result<void> finish();

  NodeStatus status() const override;
  Result<std::string> start_recording(const std::string& label) override { return record_into({}, label); }
  Result<void> stop_recording() override;
  Result<std::vector<NodeTake>> takes() const override;
  std::vector<NodeControls> controls() const override;
  Result<void> set_control(const std::string& serial, const std::string& name, double value) override;
  Result<std::vector<std::string>> presets() const override;
  Result<void> save_preset(const std::string& name) override;
  Result<void> apply_preset(const std::string& name) override;

  /// Of the take that is being recorded or was recorded last.
  std::optional<capture::RecordingQuality> quality() const;
  std::filesystem::path take() const;
  double mean_frame_rate(std::size_t camera) const { return lanes_[camera]->mean_frame_rate(); }
  bool plays_recordings() const;
  bool recording() const;
  bool agreement_seen() const { return watch_->last().any; }
  const CaptureConfig& config() const { return config_; }

 private:
  // Where a camera's frames go: into its pre-roll, or into the take.
  struct Route {
    std::mutex mutex;
    std::shared_ptr<capture::Recorder> recorder;
    std::optional<PreRoll> pre_roll;
  };
  struct Take {
    std::shared_ptr<capture::Recorder> recorder;  // while it is recorded
    std::filesystem::path folder;
    std::chrono::steady_clock::time_point begun;
    double before = 0;                                 // seconds of pre-roll
    std::optional<capture::RecordingQuality> quality;  // when it is over
    std::shared_ptr<capture::SoundRecording> sound =
        nullptr;  // while it is recorded; none where it has no sound
  };

  explicit CaptureNode(CaptureConfig config) : config_(std::move(config)) {}
  void arrived(std::size_t camera, const Frame& frame, std::uint64_t failed);
  void restarted(std::size_t camera);
  Result<std::filesystem::path> new_folder(const std::string& label) const;
  Timestamp newest() const;
  Timestamp now() const;  // on the clock of the pictures
  std::optional<Timestamp> origin_of_take() const;
  void hand_over(const std::shared_ptr<capture::Recorder>& recorder);
  void wait_for_the_end(const capture::Recorder& recorder) const;
  Result<void> end_take();  // under control_

  const CaptureConfig config_;
  std::vector<std::unique_ptr<CameraLane>> lanes_;
  std::vector<std::unique_ptr<Route>> routes_;
  std::unique_ptr<SyncWatch> watch_;
  std::vector<Tap> taps_;
  std::atomic<bool> take_failed_{false};
  std::chrono::steady_clock::time_point looked_at_disk_, saved_quality_;
  mutable std::mutex presets_;  // over their file
  std::mutex control_;          // one command at a time
  mutable std::mutex mutex_;    // over what follows
  Take take_;
  std::string last_recording_;
  TakeSealer sealer_{[this] { return !recording(); }};  // last: it asks about what stands above
};

}  // namespace floatstage::studio
