#pragma once

#include <cstddef>
#include <functional>

#include <sys/types.h>

namespace floatstage {

/// Another process that runs a piece of this test: what is killed, or starved of disk, there harms nothing
/// here. Made by fork(): begin it while the test has no other thread.
class ChildProcess {
 public:
  /// `body` gets a function that reports one more step to the parent; its return value is the exit status
  /// (0…100).
  explicit ChildProcess(const std::function<int(const std::function<void()>& report)>& body);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits until the child has reported that often; false when it ended before.
  bool wait_for_reports(std::size_t reports);
  /// SIGKILL, as `kill -9`: the child gets no chance to tidy up.
  void kill();
  /// Its exit status, or -1 when it died of a signal.
  int wait();

 private:
  pid_t pid_ = -1;
  int reports_fd_ = -1;
  std::size_t reports_ = 0;
};

/// For a child: from here on no file grows beyond `bytes`, as on a full disk.
void let_files_grow_to(std::size_t bytes);

}  // namespace floatstage
