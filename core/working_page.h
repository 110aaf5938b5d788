#pragma once

#include <atomic>
#include <cstdint>

namespace floatstage {

/// What the threads of a confined child decode, in memory that it shares with its parent; there is none in
/// other processes. The parent believes nothing of it beyond its bounds.
struct WorkingPage {
  static constexpr unsigned kPlaces = 256;
  /// One thread's.
  struct Place {
    std::atomic<std::uint32_t> steps;  ///< odd while it is inside of a WorkingOn
    std::atomic<bool> failed;          ///< it died here, or was left by an exception
    char name[1024];                   ///< of the file, ends with 0
  };
  std::atomic<unsigned> taken;
  std::atomic<bool> to_end;  ///< the parent asks the child to end by itself
  Place places[kPlaces];
};

extern WorkingPage* g_working_page;
extern thread_local WorkingPage::Place* t_working_place;

}  // namespace floatstage
