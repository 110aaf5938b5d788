#include "studio/node/publishing_node.h"

#include <algorithm>
#include <cmath>

#include "core/log.h"
#include "studio/messages/clock.h"
#include "studio/node/key_samples.h"

namespace floatstage::studio {
namespace {

constexpr Nanoseconds kLook = milliseconds(50);  // how often an idle node looks whether it is to end
constexpr Nanoseconds kStatusPeriod = milliseconds(1000);

std::shared_ptr<const CameraView> moved(const CameraView& view, Nanoseconds by) {
  auto out = std::make_shared<CameraView>(view);
  out->instant = view.instant + by;
  out->exposed = view.exposed + by;
  out->produced = view.produced + by;
  return out;
}

}  // namespace

Result<std::unique_ptr<PublishingNode>> PublishingNode::open(const Rig& rig, double frame_rate,
                                                             const PublishingOptions& options,
                                                             StudioControl& control) {
  std::unique_ptr<PublishingNode> node(new PublishingNode(rig, options, control));
  if (Result<void> ok = check(options.quality); !ok) return forward(ok);
  if (Result<void> ok = node->load_plates(); !ok) return forward(ok);
  capture::SyncOptions sync;
  sync.frame_rate = frame_rate;
  sync.offsets = options.offsets;
  sync.tolerance = std::min(options.tolerance, Nanoseconds{std::llround(4e8 / frame_rate)});
  sync.longest_wait = std::max(options.longest_wait, Nanoseconds{std::llround(5e8 / frame_rate)});
  Result<std::unique_ptr<SetBuilder>> sets = SetBuilder::make(static_cast<int>(rig.cameras.size()), sync);
  if (!sets) return forward(sets);
  node->sets_ = std::move(*sets);
  Result<std::unique_ptr<wire::Publisher>> publisher = wire::Publisher::bind(options.publisher);
  if (!publisher) return forward(publisher);
  node->publisher_ = std::move(*publisher);
  if (!options.control.empty()) {
    Result<std::unique_ptr<wire::ControlServer>> server =
        wire::ControlServer::bind(options.control, options.publisher.keys, control);
    if (!server) return forward(server);
    node->server_ = std::move(*server);
  }
  node->thread_ = std::thread([n = node.get()] { n->run(); });
  return node;
}

PublishingNode::~PublishingNode() {
  stopping_ = true;
  if (sets_) sets_->close();
  if (thread_.joinable()) thread_.join();
}

void PublishingNode::push(const Frame& frame, Timestamp arrived) {
  Frame here = frame;
  here.info.exposure_start = time_.to_monotonic(frame.info.exposure_start, arrived);
  sets_->push(here, std::min(arrived, here.info.exposure_start));
}

Result<void> PublishingNode::load_plates() {
  samples_.resize(rig_.cameras.size());
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    Result<matting::KeySamples> plates = empty_stage_of(options_.plates, rig_.cameras[i].serial);
    if (!plates) return forward(plates);
    samples_[i] = std::move(*plates);
  }
  return {};
}

// Where there is no plate a keyer learns from the first picture of its camera. Says whose is still to come.
std::string PublishingNode::collect_samples(const TimedSet& set) {
  std::string missing;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Frame& frame = set.images.frames[i];
    std::vector<Image>& pictures = samples_[i].pictures;
    if (pictures.empty() && !frame.empty() && frame.info.status == FrameStatus::Ok)
      if (Result<Image> picture = to_rgb(frame)) pictures.push_back(std::move(*picture));
    if (pictures.empty()) missing += (missing.empty() ? "" : ", ") + rig_.cameras[i].serial;
  }
  return missing;
}

void PublishingNode::look(CameraRack& rack, const TimedSet& set) {
  const Nanoseconds to_studio = time_.to_system(system_now(), now());
  std::vector<bool> textured;
  for (const RigCamera& camera : rig_.cameras) textured.push_back(publisher_->wants_tile(camera.serial));
  SceneTimes times;
  std::vector<std::shared_ptr<const CameraView>> views;
  rack.look(set, textured, options_.quality, options_.threads, times, views);
  for (const auto& view : views)
    if (view) publisher_->publish(moved(*view, to_studio));
  ++looked_;
  if (!rack.trouble().empty()) ++troubled_;
}

void PublishingNode::run() {
  std::optional<CameraRack> rack;
  std::string trouble;
  Timestamp told;
  const auto complain = [&](const std::string& what) {
    if (what != trouble && !what.empty()) log::warning(what);
    trouble = what;
  };
  while (!stopping_) {
    if (now() - told >= kStatusPeriod) {
      told = now();
      publisher_->publish(control_.status());
    }
    const std::optional<TimedSet> set = sets_->newest(now() + kLook);
    if (!set) continue;
    if (!rack) {
      const std::string missing = collect_samples(*set);
      if (!missing.empty()) {
        complain("nothing is published until each camera has shown a picture; waiting for " + missing);
        continue;
      }
      Result<CameraRack> made = CameraRack::make(rig_, options_.key, samples_);
      complain(made ? "" : made.error().message);
      if (!made) continue;  // perhaps the next pictures are better
      rack.emplace(std::move(*made));
    }
    look(*rack, *set);
    complain(rack->trouble());
  }
}

PublishingCounters PublishingNode::counters() const {
  PublishingCounters counters;
  counters.publisher = publisher_->counters();
  if (server_) counters.control = server_->counters();
  counters.sets = sets_->counters();
  counters.seconds = seconds(now() - opened_);
  counters.looked = looked_;
  counters.troubled = troubled_;
  return counters;
}

}  // namespace floatstage::studio
