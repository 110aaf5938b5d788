#include "studio/live/recon_service.h"

#include "capture/sha256.h"
#include "core/log.h"
#include "core/rig_io.h"
#include "studio/messages/clock.h"

namespace floatstage::studio {
namespace {

// How long an idle service sleeps: instants settle by time too.
constexpr Nanoseconds kLook = milliseconds(5);

std::vector<std::string> serials_of(const Rig& rig) {
  std::vector<std::string> serials;
  for (const RigCamera& camera : rig.cameras) serials.push_back(camera.serial);
  return serials;
}

}  // namespace

std::string digest_of(const Rig& rig) { return capture::sha256(to_json(rig)); }

ReconService::ReconService(const Rig& rig, const ReconOptions& options)
    : options_(options),
      reconstruction_(rig, digest_of(rig)),
      watch_(rig),
      gatherer_(serials_of(rig), options.gather) {}

Result<std::unique_ptr<ReconService>> ReconService::open(const Rig& rig, const ReconOptions& options) {
  std::unique_ptr<ReconService> service(new ReconService(rig, options));
  Result<std::unique_ptr<wire::Publisher>> publisher = wire::Publisher::bind(options.publisher);
  if (!publisher) return forward(publisher);
  service->publisher_ = std::move(*publisher);
  Result<std::unique_ptr<wire::Subscriber>> subscriber =
      wire::Subscriber::connect({options.nodes,
                                 options.publisher.keys,
                                 {wire::MessageKind::Outline},
                                 static_cast<int>(16 * rig.cameras.size())});
  if (!subscriber) return forward(subscriber);
  service->subscriber_ = std::move(*subscriber);
  service->thread_ = std::thread([s = service.get()] { s->run(); });
  return service;
}

ReconService::~ReconService() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
}

void ReconService::say(const std::string& remark, std::string& before) {
  if (remark != before && !remark.empty()) log::warning(remark);
  before = remark;
}

void ReconService::make_scene(const GatheredViews& set) {
  const Timestamp begun = now();
  auto scene = std::make_shared<StudioScene>();
  const Result<void> made = reconstruction_.make(set.views, options_.threads, *scene);
  const std::string remark = made ? reconstruction_.remark() : made.error().message;
  say(remark, remark_);
  if (made) watch_.offer(reconstruction_.outlines(), {});
  const std::string silhouettes = watch_.news()->remark();
  say(silhouettes, silhouettes_);
  scene->remark = remark.empty() ? silhouettes : remark;
  const std::lock_guard lock(mutex_);
  counters_.hull_ms.add(milliseconds_of(now() - begun));
  if (!made) {
    ++counters_.failed;
    return;
  }
  scene->epoch = counters_.scenes++;
  scene->instant = set.instant;
  publisher_->publish(std::shared_ptr<const StudioScene>(std::move(scene)));
}

void ReconService::run() {
  while (!stopping_) {
    const auto studio_time = [by = to_studio_time()] { return now() + by; };
    Nanoseconds wait = kLook;
    while (std::optional<wire::Received> received = subscriber_->next(wait)) {
      if (auto* view = std::get_if<std::shared_ptr<const CameraView>>(&*received))
        gatherer_.push(std::move(*view), studio_time());
      wait = {};
    }
    const std::optional<GatheredViews> set = gatherer_.newest(studio_time());
    say(gatherer_.remark(), clocks_);
    {
      const std::lock_guard lock(mutex_);
      counters_.gathered = gatherer_.counters();
    }
    if (set) make_scene(*set);
  }
}

ReconCounters ReconService::counters() const {
  const std::lock_guard lock(mutex_);
  ReconCounters counters = counters_;
  counters.from_nodes = subscriber_->counters();
  counters.to_viewers = publisher_->counters();
  return counters;
}

}  // namespace floatstage::studio
