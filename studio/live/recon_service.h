#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "studio/live/live_stats.h"
#include "studio/live/reconstruction.h"
#include "studio/live/silhouette_watch.h"
#include "studio/live/view_gatherer.h"
#include "studio/network/publisher.h"
#include "studio/network/subscriber.h"

namespace floatstage::studio {

/// The name of a rig on the network: scenes carry it, and a viewer with another rig says so.
std::string digest_of(const Rig& rig);

struct ReconOptions {
  std::vector<std::string> nodes;  ///< addresses of the capture nodes
  wire::PublisherOptions publisher;
  GatherOptions gather;
  int threads = 0;
};

struct ReconCounters {
  wire::SubscriberCounters from_nodes;
  wire::PublisherCounters to_viewers;
  ViewGatherer::Counters gathered;
  std::uint64_t scenes = 0;  ///< made and told
  std::uint64_t failed = 0;  ///< instants without a scene
  Series hull_ms;
};

/// The machine that reconstructs: outlines of all capture nodes in, scenes out, on a thread of its own.
/// Always the newest instant: what comes while it works is overtaken, and counted. No picture comes here.
class ReconService {
 public:
  /// Errors: those of Publisher::bind() and Subscriber::connect().
  static Result<std::unique_ptr<ReconService>> open(const Rig& rig, const ReconOptions& options);
  ~ReconService();

  const std::string& address() const { return publisher_->address(); }
  ReconCounters counters() const;

 private:
  ReconService(const Rig& rig, const ReconOptions& options);
  void run();
  void make_scene(const GatheredViews& set);
  static void say(const std::string& remark, std::string& before);

  const ReconOptions options_;
  Reconstruction reconstruction_;
  SilhouetteWatch watch_;
  ViewGatherer gatherer_;
  std::string remark_, clocks_, silhouettes_;  // what was said last of scenes, clocks, silhouettes
  std::unique_ptr<wire::Subscriber> subscriber_;
  std::unique_ptr<wire::Publisher> publisher_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;  // over what follows
  ReconCounters counters_;
  std::thread thread_;
};

}  // namespace floatstage::studio
