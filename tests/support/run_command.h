#pragma once

#include <cstdio>
#include <string>

#include <sys/wait.h>

namespace floatstage {

/// How a command ended.
struct Ended {
  int code;            ///< its exit status, or -1 when it died of a signal
  std::string output;  ///< standard output and error together
};

/// Runs `command` by the shell, with nothing to read, and waits for it.
inline Ended run_command(const std::string& command) {
  Ended ended = {.code = -1, .output = {}};
  FILE* pipe = popen(("exec </dev/null; " + command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return ended;
  char buffer[4096];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) ended.output.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  return ended;
}

}  // namespace floatstage
