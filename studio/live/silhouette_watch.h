#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/frame.h"
#include "core/time.h"
#include "studio/live/silhouette_findings.h"

namespace floatstage::studio {

/// What is wrong with the silhouettes of a running studio.
struct SilhouetteNews {
  std::vector<std::string> doubts;        ///< sentences; empty when nothing is wrong
  std::vector<std::string> cameras = {};  ///< that they name, in the rig's order
  /// Those cameras' photographs with their silhouettes; empty until there was an instant to make it of, and
  /// where photographs are on other machines.
  Image picture = {};

  std::string remark() const;  ///< all doubts in one line; empty when nothing is wrong
};

/// Looks now and then whether the silhouettes of a running studio fit together: a key that fails during a
/// session makes wrong scenes without a word. A thread of its own, which gives way to those that make the
/// scenes, judges one instant, rests and takes the next. What was found in two instants in a row is said,
/// with the numbers of then, until it was not found in two in a row.
class SilhouetteWatch {
 public:
  /// `key`: what keys the cameras (CameraRack::keys()), as far as it is known here.
  /// `rest`: how long it does nothing after an instant.
  explicit SilhouetteWatch(const Rig& rig, const std::string& key = "",
                           Nanoseconds rest = milliseconds(2000));
  ~SilhouetteWatch();
  SilhouetteWatch(const SilhouetteWatch&) = delete;
  SilhouetteWatch& operator=(const SilhouetteWatch&) = delete;

  /// An instant: outlines[i] and photographs[i], which may be missing altogether, belong to rig.cameras[i].
  /// Returns at once; true: a copy of what is needed was taken, since the watch has time for it. One thread
  /// at a time.
  bool offer(std::span<const Silhouette> outlines, std::span<const Frame> photographs);

  /// What is said at present, never null. Any thread.
  std::shared_ptr<const SilhouetteNews> news() const;
  /// How many instants were judged. Any thread.
  std::uint64_t judged() const;

 private:
  /// A finding's last sightings: `steps` go up where it is found and down where not, from 0 to kSteps.
  struct Said {
    SilhouetteFinding finding;
    int steps = 0;
    bool said = false;
  };
  void run();
  bool note(std::vector<SilhouetteFinding> found);
  void tell(const std::vector<Image>& rgb);

  const Rig rig_;
  SilhouetteFindings findings_;  // the watch's thread only, as the next
  std::map<std::string, Said> known_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Silhouette> outlines_;
  std::vector<Frame> photographs_;
  std::shared_ptr<const SilhouetteNews> news_ = std::make_shared<SilhouetteNews>();
  std::uint64_t judged_ = 0;
  const Nanoseconds rest_;
  Timestamp rested_;  // when the next instant is wanted
  bool full_ = false, shows_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace floatstage::studio
