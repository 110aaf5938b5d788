#include "apps/terminal/interrupt.h"

#include <atomic>

#include <signal.h>

namespace floatstage::apps {
namespace {

std::atomic<bool> g_interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may use it");

void on_signal(int) { g_interrupted = true; }

}  // namespace

void watch_for_interrupts() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one is the default: it ends the process
  // A closed terminal ends work as Ctrl-C does; a reader of our lines who has gone ends nothing.
  for (const int ending : {SIGINT, SIGTERM, SIGHUP}) sigaction(ending, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

bool interrupted() { return g_interrupted; }

}  // namespace floatstage::apps
