#include "studio/live/camera_source.h"

#include <algorithm>

#include "core/log.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "studio/messages/clock.h"
#include "studio/node/key_samples.h"
#include "studio/node/take_rig.h"

namespace floatstage::studio {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);  // whether it is to end

}  // namespace

Result<std::unique_ptr<CameraSource>> CameraSource::open(CaptureConfig config,
                                                         const std::filesystem::path& plates,
                                                         const std::function<bool()>& stop,
                                                         Nanoseconds patience) {
  if (config.rig.empty())
    return fail(ErrorCode::InvalidArgument,
                "the studio's file names no rig: a live scene needs calibrated cameras; add rig = "
                "\"rig.json\" to [studio]");
  Result<Rig> rig = load_rig(config.rig);
  if (!rig) return forward(rig);
  std::unique_ptr<CameraSource> source(new CameraSource);
  for (const CaptureConfig::Camera& camera : config.cameras) {
    const int index = camera_index(*rig, camera.serial);
    if (index < 0)
      return fail(ErrorCode::NotFound, text(config.rig.string(), ": camera '", camera.serial,
                                            "' is not in it; calibrate again or correct the serial"));
    source->rig_.cameras.push_back(rig->cameras[static_cast<std::size_t>(index)]);
  }
  Result<std::unique_ptr<CaptureNode>> node = CaptureNode::open(std::move(config), stop);
  if (!node) return forward(node);
  source->node_ = std::move(*node);
  source->first_.resize(source->rig_.cameras.size());
  source->node_->add_tap([raw = source.get()](const Frame& frame) { raw->arrived(frame); });
  source->node_->begin();
  if (Result<void> ok = source->wait_for_pictures(stop, patience); !ok) return forward(ok);
  if (Result<void> ok = source->learn(plates); !ok) return forward(ok);
  return source;
}

std::vector<Nanoseconds> CameraSource::time_offsets() const {
  return capture::offsets_of(node_->config().recorder.times, rig_);
}

void CameraSource::arrived(const Frame& frame) {
  const Timestamp produced = time_.produced(frame.info.exposure_start, now());
  std::shared_ptr<const Tap> tap;
  {
    const std::lock_guard lock(mutex_);
    tap = tap_;
    if (!tap) {
      Frame& first = first_[static_cast<std::size_t>(frame.info.camera)];
      if (first.empty() && !frame.empty() && frame.info.status == FrameStatus::Ok)
        first = capture::detached(frame);
    }
  }
  if (tap) {
    (*tap)(frame, produced);
  } else {
    arrived_.notify_one();
  }
}

Result<void> CameraSource::wait_for_pictures(const std::function<bool()>& stop, Nanoseconds patience) {
  std::unique_lock lock(mutex_);
  const auto all = [&] {
    return std::none_of(first_.begin(), first_.end(), [](const Frame& f) { return f.empty(); });
  };
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(patience.count);
  while (std::chrono::steady_clock::now() < end) {
    if (arrived_.wait_for(lock, kLook, all)) return {};
    if (stop && stop()) return fail(ErrorCode::Cancelled, "interrupted before the first pictures came");
  }
  for (std::size_t i = 0; i < first_.size(); ++i)
    if (first_[i].empty())
      return fail(ErrorCode::Timeout,
                  text("camera '", rig_.cameras[i].serial, "' delivers no picture; check its trigger"));
  return {};
}

Result<void> CameraSource::learn(const std::filesystem::path& plates) {
  for (std::size_t i = 0; i < first_.size(); ++i) {
    Result<matting::KeySamples> samples = empty_stage_of(plates, rig_.cameras[i].serial);
    if (!samples) return forward(samples);
    if (!samples->empty_stage) {
      Result<Image> picture = to_rgb(first_[i]);
      if (!picture) return forward(picture);
      samples->pictures.push_back(std::move(*picture));
    }
    samples_.push_back(std::move(*samples));
    first_[i] = {};
  }
  return {};
}

std::string CameraSource::description() const {
  return text(rig_.cameras.size(), " cameras of '", node_->config().name, "' at ", frame_rate(),
              " frames a second: latency counts from each frame's exposure");
}

void CameraSource::begin(Tap tap) {
  const std::lock_guard lock(mutex_);
  tap_ = std::make_shared<const Tap>(std::move(tap));
}

void CameraSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    tap_ = std::make_shared<const Tap>([](const Frame&, Timestamp) {});
  }
  if (!node_) return;
  if (const Result<void> ended = node_->finish(); !ended) log::error(ended.error().message);
}

}  // namespace floatstage::studio
