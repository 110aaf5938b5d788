#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::calib {

/// How another program ended.
struct ProgramEnd {
  int code = 0;    ///< exit code, when it ended by itself
  int signal = 0;  ///< the signal that ended it, or 0
};

/// Runs a program (found by PATH) to its end, its output appended to `log`. Private to calib. `cancelled`,
/// where there is one, is asked several times a second. NotFound when there is no such program; Timeout after
/// `seconds` and Cancelled, with the program and its children killed; Io when the log cannot be written.
Result<ProgramEnd> run_program(const std::vector<std::string>& arguments, const std::filesystem::path& log,
                               double seconds, const std::function<bool()>& cancelled = nullptr);

/// The last lines of a log, for an error's sentence; empty when there is none.
std::string end_of_log(const std::filesystem::path& log, std::size_t lines = 3);

}  // namespace floatstage::calib
