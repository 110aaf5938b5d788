// Part of every test program: one that crashes says where, for crashes that come once in hundreds of runs.

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <execinfo.h>
#include <unistd.h>

namespace floatstage {
namespace {

constexpr int kMostFrames = 64;

// Only what a signal handler may call.
void on_crash(int signal_number, siginfo_t* what, void*) {
  std::array<char, 96> line = {};
  const int length =
      std::snprintf(line.data(), line.size(), "crashed (signal %d) at address %p, called from\n",
                    signal_number, what->si_addr);
  if (::write(STDERR_FILENO, line.data(), static_cast<std::size_t>(length)) < 0) ::_exit(1);
  std::array<void*, kMostFrames> frames = {};
  ::backtrace_symbols_fd(frames.data(), ::backtrace(frames.data(), kMostFrames), STDERR_FILENO);
  ::signal(signal_number, SIG_DFL);
  ::raise(signal_number);
}

[[maybe_unused]] const bool kInstalled = [] {
  std::array<void*, 1> first = {};
  ::backtrace(first.data(), 1);  // loads what it needs: the handler must not
  struct sigaction action = {};
  action.sa_sigaction = &on_crash;
  action.sa_flags = SA_SIGINFO;
  for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) ::sigaction(crash, &action, nullptr);
  return true;
}();

}  // namespace
}  // namespace floatstage
