#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "studio/messages/clock.h"
#include "studio/messages/studio_control.h"
#include "studio/network/control_server.h"
#include "studio/network/publisher.h"
#include "studio/node/camera_rack.h"
#include "studio/node/camera_time.h"
#include "studio/node/set_builder.h"

namespace floatstage::studio {

struct PublishingOptions {
  wire::PublisherOptions publisher;
  std::string control;       ///< address where requests are answered; empty: nowhere
  std::string key = "auto";  ///< keyer spec, or "auto": each camera's own
  std::filesystem::path
      plates;  ///< clean plates, <serial>.png; where one is not there the first picture is looked at
  NodeQuality quality;
  Nanoseconds tolerance = milliseconds(4);      ///< of the exposures of one instant
  Nanoseconds longest_wait = milliseconds(30);  ///< for a camera that is late; half a period at least
  std::vector<Nanoseconds> offsets = {};        ///< capture::SyncOptions::offsets
  int threads = 0;                              ///< that look at pictures; 0: one per core
};

struct PublishingCounters {
  wire::PublisherCounters publisher;
  wire::ControlCounters control;
  SetBuilder::Counters sets;
  double seconds = 0;          ///< since it was opened
  std::uint64_t looked = 0;    ///< instants that were keyed
  std::uint64_t troubled = 0;  ///< of them: with a picture that could not be used
};

/// The part of a capture node that looks at its cameras' pictures and tells the studio: outlines always,
/// textures of the cameras that somebody subscribed to, its status once a second. Works on a thread of its
/// own and on the newest instant; when the machine is too slow instants are left out and counted, and neither
/// capture nor recording waits. What it tells has the studio's common time (to_studio_time()).
class PublishingNode {
 public:
  /// `control` answers requests and gives the status; it must outlive the node. Errors: addresses, ports,
  /// keys; a plate that cannot be read.
  static Result<std::unique_ptr<PublishingNode>> open(const Rig& rig, double frame_rate,
                                                      const PublishingOptions& options,
                                                      StudioControl& control);
  ~PublishingNode();

  /// A frame that has just arrived; info.camera is its place in the rig. Called on the cameras' threads,
  /// those of one camera one after the other. Does not wait.
  void push(const Frame& frame, Timestamp arrived);

  const std::string& address() const { return publisher_->address(); }
  std::string control_address() const { return server_ ? server_->address() : ""; }
  PublishingCounters counters() const;

 private:
  PublishingNode(const Rig& rig, const PublishingOptions& options, StudioControl& control)
      : rig_(rig), options_(options), control_(control), opened_(now()) {}
  Result<void> load_plates();
  std::string collect_samples(const TimedSet& set);
  void run();
  void look(CameraRack& rack, const TimedSet& set);

  const Rig rig_;
  const PublishingOptions options_;
  StudioControl& control_;
  std::vector<matting::KeySamples> samples_;  // per camera
  CameraTime time_;
  std::unique_ptr<SetBuilder> sets_;
  std::unique_ptr<wire::Publisher> publisher_;
  std::unique_ptr<wire::ControlServer> server_;
  const Timestamp opened_;
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> looked_{0}, troubled_{0};
  std::thread thread_;
};

}  // namespace floatstage::studio
