#pragma once

#include <string>
#include <vector>

namespace floatstage {

/// How a run of the program ended.
struct HostileRun {
  int status = -1;     ///< of waitpid; -1: it still ran after `seconds`, and was killed
  long kilobytes = 0;  ///< the most memory that it or one of its processes had
  std::string said;    ///< on standard error
};

/// Runs these words, the first being a program, with more variables ("NAME=value") in its environment.
HostileRun hostile_run(const std::vector<std::string>& words, int seconds,
                       const std::vector<std::string>& environment = {});

/// What every run has to keep to: it ends within 20 s, by no signal, with no check of our own failed, and in
/// less than 500 MB. `what` names it in a failure. Its exit status.
int expect_orderly(const std::vector<std::string>& words, const std::string& what);

}  // namespace floatstage
