#include "studio/live/remote_scenes.h"

#include <algorithm>

#include "core/log.h"
#include "core/text.h"
#include "studio/live/recon_service.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

// How often a scene that waits for its tiles is looked at.
constexpr Nanoseconds kLook = milliseconds(2);
constexpr int kQueue = 64;
constexpr Nanoseconds kSilence = milliseconds(3000);  // of the reconstruction, before one says so
constexpr double kLongestPeriod = 2;                  // seconds between scenes; more is an interruption

std::vector<std::string> serials_of(const Rig& rig) {
  std::vector<std::string> serials;
  for (const RigCamera& camera : rig.cameras) serials.push_back(camera.serial);
  return serials;
}

}  // namespace

RemoteScenes::RemoteScenes(const Rig& rig, const RemoteOptions& options)
    : rig_(rig), recon_(options.recon), digest_(digest_of(rig)), join_(serials_of(rig), options.join) {}

Result<std::unique_ptr<RemoteScenes>> RemoteScenes::open(const Rig& rig, const RemoteOptions& options) {
  std::unique_ptr<RemoteScenes> scenes(new RemoteScenes(rig, options));
  wire::SubscriberOptions from{options.nodes, options.keys, {wire::MessageKind::Scene}, kQueue};
  from.addresses.push_back(options.recon);
  Result<std::unique_ptr<wire::Subscriber>> subscriber = wire::Subscriber::connect(from);
  if (!subscriber) return forward(subscriber);
  scenes->subscriber_ = std::move(*subscriber);
  scenes->heard_ = now();
  return scenes;
}

void RemoteScenes::take(const wire::Received& received) {
  if (const auto* tile = std::get_if<std::shared_ptr<const CameraView>>(&received)) {
    join_.push(*tile);
  } else if (const auto* scene = std::get_if<std::shared_ptr<const StudioScene>>(&received)) {
    const bool ours = (*scene)->rig_sha256 == digest_;
    if (ours) {
      heard_ = now();
      silent_ = false;
      if (remark_ != (*scene)->remark && !(*scene)->remark.empty()) log::warning((*scene)->remark);
      remark_ = (*scene)->remark;
      const double period = seconds((*scene)->instant - last_instant_);
      last_instant_ = (*scene)->instant;
      if (period > 0 && period < kLongestPeriod)
        frame_rate_ = frame_rate_ == 0 ? 1 / period : 1 / (0.9 / frame_rate_ + 0.1 * period);
      return join_.push(*scene, now());
    }
    if (other_rig_++ == 0)
      log::warning(
          "scenes come that were made with another rig.json than this viewer's; copy the same to all "
          "machines");
    remark_ = "scenes come that were made with another rig.json";
  }
}

void RemoteScenes::notice_silence(Timestamp time) {
  if (silent_ || time - heard_ < kSilence) return;
  silent_ = true;
  if (!remark_.empty()) return;  // scenes of another rig come
  remark_ = text("no scene comes from ", recon_,
                 "; is `floatstage live recon` running there, with this studio's keys and with nodes that "
                 "see something?");
  log::warning(remark_);
}

std::shared_ptr<const LiveScene> RemoteScenes::newest(Timestamp deadline) {
  for (;;) {
    while (const std::optional<wire::Received> received = subscriber_->next({})) take(*received);
    const Timestamp time = now();
    if (const std::shared_ptr<LiveScene> scene = join_.newest(time)) {
      scene->scene.produced =
          scene->scene.produced - to_studio_time();  // latency counts by this machine's clock
      return scene;
    }
    notice_silence(time);
    if (time >= deadline) return nullptr;
    if (const std::optional<wire::Received> received = subscriber_->next(std::min(kLook, deadline - time)))
      take(*received);
  }
}

void RemoteScenes::want(const std::vector<int>& cameras) {
  std::set<std::string> serials;
  for (int camera : cameras) serials.insert(rig_.cameras[static_cast<std::size_t>(camera)].serial);
  join_.want({cameras.begin(), cameras.end()});
  subscriber_->want_tiles(std::move(serials));
}

SceneFeed::Counters RemoteScenes::counters() const {
  Counters counters;
  counters.sets.sets = join_.counters().scenes;
  counters.sets.overtaken = join_.counters().overtaken;
  counters.scenes = join_.counters().shown;
  return counters;
}

RemoteScenes::NetworkCounters RemoteScenes::network() const {
  return {subscriber_->counters(), join_.counters(), other_rig_};
}

}  // namespace floatstage::studio
