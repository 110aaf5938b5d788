#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "studio/live/live_source.h"
#include "studio/node/camera_time.h"
#include "studio/node/capture_node.h"

namespace floatstage::studio {

/// The cameras of a studio's TOML file, each on a thread of its own, as a live chain's source: GigE, V4L2,
/// whatever open_source() knows. They can be recorded at the same time (control()).
class CameraSource final : public LiveSource {
 public:
  /// Starts the cameras and waits for a picture of each, from which its keyer learns unless `plates` has its
  /// clean plate
  /// (<serial>.png). Errors: those of CaptureNode::open() and load_rig(); InvalidArgument for a config
  /// without a rig, NotFound for a camera that the rig does not have, Timeout for one that delivers nothing
  /// within `patience`. Cancelled once `stop`, which is asked from several threads, says yes.
  static Result<std::unique_ptr<CameraSource>> open(CaptureConfig config, const std::filesystem::path& plates,
                                                    const std::function<bool()>& stop = {},
                                                    Nanoseconds patience = milliseconds(10'000));
  ~CameraSource() override { stop(); }

  const Rig& rig() const override { return rig_; }
  double frame_rate() const override { return node_->config().frame_rate; }
  std::vector<Nanoseconds> time_offsets() const override;
  std::vector<matting::KeySamples> samples() const override { return samples_; }
  std::string description() const override;
  void begin(Tap tap) override;
  bool over() const override { return node_->over(); }
  void stop() override;
  void poll() override { node_->poll(); }
  StudioControl* control() override { return node_.get(); }

 private:
  CameraSource() = default;
  void arrived(const Frame& frame);
  Result<void> wait_for_pictures(const std::function<bool()>& stop, Nanoseconds patience);
  Result<void> learn(const std::filesystem::path& plates);

  std::unique_ptr<CaptureNode> node_;
  Rig rig_;
  std::vector<matting::KeySamples> samples_;
  CameraTime time_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Frame> first_;
  std::shared_ptr<const Tap> tap_;
};

}  // namespace floatstage::studio
