#pragma once

#include <cstddef>
#include <functional>

namespace floatstage {

/// Runs body(i) for every i in [0, count) on up to `threads` threads (0: one per core; 1: on this thread, in order).
/// Items are handed out one at a time; results must not depend on the order, which is what keeps outputs the same at
/// any thread count. The first exception thrown by a body is rethrown here after all threads have stopped.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// What `threads = 0` means on this machine.
int default_threads();

}  // namespace floatstage
