#include "tests/hostile/hostile_run.h"

#include <chrono>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/sanitized.h"

namespace floatstage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLongest = kSanitized ? 200 : 20;  // s
constexpr long kMostKilobytes = (kSanitized ? 4096 : 500) * 1024;
constexpr int kExitBug = 70;

std::vector<char*> pointers(const std::vector<std::string>& words) {
  std::vector<char*> out;
  for (const std::string& word : words) out.push_back(const_cast<char*>(word.c_str()));
  out.push_back(nullptr);
  return out;
}

std::string text_of(int file) {
  std::string said(static_cast<std::size_t>(std::max<off_t>(::lseek(file, 0, SEEK_END), 0)), '\0');
  const ssize_t n = ::pread(file, said.data(), said.size(), 0);
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  ::close(file);
  return said;
}

}  // namespace

HostileRun hostile_run(const std::vector<std::string>& words, int seconds,
                       const std::vector<std::string>& environment) {
  std::vector<std::string> variables = environment;
  for (char** variable = environ; *variable != nullptr; ++variable) variables.emplace_back(*variable);
  const std::vector<char*> arguments = pointers(words), all = pointers(variables);
  const int said = ::memfd_create("said", 0);
  const pid_t pid = ::fork();
  if (pid == 0) {
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int stream : {0, 1}) ::dup2(nowhere, stream);
    ::dup2(said, 2);
    ::execve(arguments[0], arguments.data(), all.data());
    ::_exit(127);
  }
  HostileRun ended;
  rusage used = {};
  for (const auto until = Clock::now() + std::chrono::seconds(seconds);;) {
    int status = 0;
    if (::wait4(pid, &status, WNOHANG, &used) == pid) {
      ended = {status, used.ru_maxrss, {}};
      break;
    }
    if (Clock::now() > until) {
      ::kill(pid, SIGKILL);
      ::wait4(pid, &status, 0, &used);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  ended.said = text_of(said);
  return ended;
}

int expect_orderly(const std::vector<std::string>& words, const std::string& what) {
  const HostileRun ended = hostile_run(words, kLongest);
  EXPECT_NE(ended.status, -1) << what << " ran for more than " << kLongest << " s";
  if (ended.status == -1) return -1;
  EXPECT_FALSE(WIFSIGNALED(ended.status))
      << what << " died of signal " << WTERMSIG(ended.status) << ": " << ended.said;
  EXPECT_NE(WEXITSTATUS(ended.status), kExitBug) << what << " failed a check of our own: " << ended.said;
  EXPECT_LT(ended.kilobytes, kMostKilobytes) << what;
  return WEXITSTATUS(ended.status);
}

}  // namespace floatstage
