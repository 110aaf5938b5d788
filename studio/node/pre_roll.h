#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "core/frame.h"

namespace floatstage::studio {

/// The last seconds of one camera, for takes that begin before somebody said so. Pictures are copies, so no
/// buffer of the device is held. Bound: `longest` of exposures, and `most_frames` pictures whatever their
/// times say. Not thread-safe.
class PreRoll {
 public:
  struct Kept {
    Frame frame;
    std::uint64_t failed = 0;  ///< the source's count at that moment
  };

  PreRoll(Nanoseconds longest, std::size_t most_frames) : longest_(longest), most_frames_(most_frames) {}

  void push(Frame frame, std::uint64_t failed);
  /// The camera was started again: its numbers begin anew, so what came before cannot be recorded with them.
  void clear() { kept_.clear(); }
  /// Everything, oldest first; then it is empty.
  std::deque<Kept> take();
  std::vector<Timestamp> times() const;

 private:
  Nanoseconds longest_;
  std::size_t most_frames_;
  std::deque<Kept> kept_;
};

/// Where a take begins: the first instant from `from` on that every camera saw, else the last one before it;
/// cameras without pictures do not count. `times` are each camera's exposures in order, `period` the time
/// between two instants. Nothing where there is no such instant.
std::optional<Timestamp> complete_instant(const std::vector<std::vector<Timestamp>>& times, Timestamp from,
                                          Nanoseconds period);

}  // namespace floatstage::studio
