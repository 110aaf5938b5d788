#include "tests/support/child_process.h"

#include <cerrno>
#include <csignal>
#include <exception>
#include <stdexcept>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace floatstage {

ChildProcess::ChildProcess(const std::function<int(const std::function<void()>& report)>& body) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("no process");
  if (pid_ == 0) {
    ::close(ends[0]);
    int status = 101;
    try {
      status = body([&] {
        if (::write(ends[1], "+", 1) != 1) ::_exit(102);
      });
    } catch (const std::exception&) {
    }
    ::_exit(status);
  }
  ::close(ends[1]);
  reports_fd_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) {
    kill();
    wait();
  }
  ::close(reports_fd_);
}

bool ChildProcess::wait_for_reports(std::size_t reports) {
  while (reports_ < reports) {
    char byte = 0;
    const ssize_t n = ::read(reports_fd_, &byte, 1);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    ++reports_;
  }
  return true;
}

void ChildProcess::kill() { ::kill(pid_, SIGKILL); }

int ChildProcess::wait() {
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void let_files_grow_to(std::size_t bytes) {
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {bytes, bytes};
  if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) throw std::runtime_error("cannot limit file sizes");
}

}  // namespace floatstage
