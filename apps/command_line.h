#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// The program's verbs and their options. `chosen` is filled by read_command_line() and must outlive the
/// tree.
std::unique_ptr<CLI::App> command_line(Chosen& chosen);

/// How a run ends that ends with its command line: help or version asked for, or a word that makes no sense.
struct Ending {
  int code = 0;        ///< kExitOk, kExitUsage, or invalid-argument's for an impossible value
  std::string output;  ///< for standard output: help, version
  std::string error;   ///< for standard error: what is wrong, and what was probably meant
};

/// Reads the words behind the program's name. Absent: a verb was chosen and `Chosen::run` does it.
std::optional<Ending> read_command_line(CLI::App& app, const std::vector<std::string>& words);

}  // namespace floatstage::apps
