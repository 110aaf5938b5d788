#include "apps/terminal/interrupt.h"

#include <atomic>
#include <cstdint>

#include <signal.h>
#include <time.h>

namespace floatstage::apps {
namespace {

// Whoever ends a process and its group, as timeout(1) and supervisors do, sends each of them two signals at
// once, in an order and at a distance that the scheduler chooses: those within a second are one.
constexpr std::int64_t kTogether = 1'000'000'000;  // ns

std::atomic<std::int64_t> g_interrupted = 0;  // ns of the steady clock; 0: it was not
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "a signal handler may use it");

std::int64_t now() {
  timespec t = {};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

void on_signal(int which) {
  std::int64_t first = 0;
  const std::int64_t at = now();
  if (g_interrupted.compare_exchange_strong(first, at) || at - first < kTogether) return;
  signal(which, SIG_DFL);
  raise(which);
}

}  // namespace

void watch_for_interrupts() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  // A closed terminal ends work as Ctrl-C does; a reader of our lines who has gone ends nothing.
  for (const int ending : {SIGINT, SIGTERM, SIGHUP}) sigaction(ending, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return g_interrupted != 0; }

}  // namespace floatstage::apps
