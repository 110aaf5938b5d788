#include "core/parallel.h"

#include <algorithm>
#include <thread>

#include "core/thread_pool.h"

namespace floatstage {

int default_threads() {
  static const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return cores;
}

void parallel_for(std::size_t count, int threads, IndexBody body) {
  const std::size_t wanted = static_cast<std::size_t>(threads > 0 ? threads : default_threads());
  const std::size_t workers = std::min(wanted, count);
  if (workers <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  static ThreadPool pool;
  pool.run(count, workers - 1, body);
}

}  // namespace floatstage
