#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "studio/messages/camera_view.h"

namespace floatstage::studio {

struct GatherOptions {
  Nanoseconds tolerance = milliseconds(4);  ///< between the instants of two nodes that mean the same one
  Nanoseconds longest_wait =
      milliseconds(60);                       ///< for a camera's view, after the instant's first one arrived
  Nanoseconds silence = milliseconds(1000);   ///< after which a camera is not waited for
  Nanoseconds ahead = milliseconds(100);      ///< an instant that is so far in the future is of a wrong clock
  Nanoseconds behind = milliseconds(10'000);  ///< and one that is so far in the past
};

/// What the cameras of all nodes saw at one instant.
struct GatheredViews {
  Timestamp instant;
  Timestamp first_produced;                              ///< latency counts from here
  std::vector<std::shared_ptr<const CameraView>> views;  ///< in the order of the serials; null: none came
};

/// Puts the views of several camera nodes together again: by the instant that their nodes' synchronisers
/// found, on a common clock, and never by the order of arrival. An instant is settled when every camera that
/// still speaks has shown its view of it, when a later one is, or when it has waited long enough. A node that
/// died is waited for once. A node whose clock is wrong by hours would make all others late: its views are
/// left out; one that is wrong by less makes instants of its own. remark() tells of both.
///
/// Owned by one thread. Time is a parameter, on the clock that instants are told by.
class ViewGatherer {
 public:
  struct Counters {
    std::uint64_t views = 0;            ///< that came
    std::uint64_t unknown_cameras = 0;  ///< of cameras that nobody expects
    std::uint64_t late = 0;             ///< their instant had gone
    std::uint64_t off_clock = 0;        ///< their instant cannot be
    std::uint64_t sets = 0;             ///< that were handed out
    std::uint64_t incomplete = 0;       ///< of them: without the view of a camera
    std::uint64_t overtaken = 0;        ///< instants that a newer one was handed out before
  };

  ViewGatherer(std::vector<std::string> serials, const GatherOptions& options);

  void push(std::shared_ptr<const CameraView> view, Timestamp now);
  /// The newest settled instant; the older ones are gone with it. Nothing when none is.
  std::optional<GatheredViews> newest(Timestamp now);
  const Counters& counters() const { return counters_; }
  /// Whose clocks do not agree with the others', and by how much; empty while all do.
  std::string remark() const;

 private:
  struct Open {
    GatheredViews set;
    Timestamp begun;  // when its first view arrived
    std::size_t here = 0;
  };
  // One camera's clock against the others'.
  struct Clock {
    std::deque<Timestamp> instants;  // its last ones
    std::optional<Nanoseconds> off;  // against an instant that it was missing in
    int times = 0;                   // so often in a row
  };
  using Sets = std::map<Timestamp, Open>;

  Sets::iterator set_of(Timestamp instant);
  bool is_settled(const Open& open, Timestamp now) const;
  void compare_clocks(const GatheredViews& set, Timestamp now);

  const std::vector<std::string> serials_;
  const GatherOptions options_;
  std::vector<std::optional<Timestamp>> heard_;  // when each camera spoke last
  std::vector<Clock> clocks_;
  Sets open_;
  std::optional<Timestamp> gone_;  // the last instant that was handed out
  Counters counters_;
};

}  // namespace floatstage::studio
