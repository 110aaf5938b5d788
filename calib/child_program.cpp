#include "calib/child_program.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"
#include "core/text.h"

extern char** environ;

namespace floatstage::calib {
namespace {

class OpenFile {
 public:
  explicit OpenFile(int fd) : fd_(fd) {}
  ~OpenFile() {
    if (fd_ >= 0) close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

ProgramEnd reap(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {.code = 0, .signal = WTERMSIG(status)};
  return {.code = WEXITSTATUS(status), .signal = 0};
}

// Whether the program ended within that time, and nobody cancelled it.
bool wait_for_end(pid_t child, double seconds, const std::function<bool()>& cancelled) {
  const double glance = cancelled ? 0.2 : 3600;  // seconds
  const OpenFile handle(static_cast<int>(syscall(SYS_pidfd_open, child, 0)));
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const double left = std::chrono::duration<double>(until - std::chrono::steady_clock::now()).count();
    if (left <= 0 || (cancelled && cancelled())) return false;
    pollfd waiting{.fd = handle.get(), .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::ceil(std::min(left, glance) * 1000)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

}  // namespace

Result<ProgramEnd> run_program(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                               double seconds, const std::function<bool()>& cancelled) {
  FLOATSTAGE_CHECK(!arguments.empty(), "no program");
  const OpenFile output(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (output.get() < 0)
    return fail(ErrorCode::Io, text(log.string(), ": cannot be written: ", std::strerror(errno)));
  std::vector<char*> words;
  for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
  words.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawnattr_t how;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output.get(), 1);
  posix_spawn_file_actions_adddup2(&files, output.get(), 2);
  posix_spawnattr_init(&how);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP);  // a group of its own: killed with its children
  posix_spawnattr_setpgroup(&how, 0);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, words[0], &files, &how, words.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&how);
  if (failed == ENOENT)
    return fail(ErrorCode::NotFound, text("the program '", arguments[0], "' is not installed"));
  if (failed != 0)
    return fail(ErrorCode::Io,
                text("the program '", arguments[0], "' cannot be started: ", std::strerror(failed)));
  if (!wait_for_end(child, seconds, cancelled)) {
    kill(-child, SIGKILL);
    reap(child);
    if (cancelled && cancelled())
      return fail(ErrorCode::Cancelled, text("'", arguments[0], "' was interrupted"));
    return fail(ErrorCode::Timeout, text("'", arguments[0], arguments.size() > 1 ? " " + arguments[1] : "",
                                         "' took longer than ", seconds, " s and was ended"));
  }
  return reap(child);
}

std::string end_of_log(const std::filesystem::path& log, std::size_t lines) {
  const Result<std::string> bytes = read_file(log);
  if (!bytes) return {};
  std::string end = *bytes;
  while (!end.empty() && end.back() == '\n') end.pop_back();
  std::size_t at = end.size();
  for (std::size_t i = 0; i < lines && at != std::string::npos; ++i)
    at = at == 0 ? std::string::npos : end.rfind('\n', at - 1);
  if (at != std::string::npos) end.erase(0, at + 1);
  for (char& c : end)
    if (c == '\n') c = ';';
  return end;
}

}  // namespace floatstage::calib
