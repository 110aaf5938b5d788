#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// A job that reads foreign files, and what it makes of them.
struct ConfinedOutputs {
  std::string what;  ///< names the job where no file is known
  /// Files and folders that it makes, in the order in which they get their names; empty ones are none.
  std::vector<std::filesystem::path> outputs;
  /// A folder that it works in as it stands, made where it is not there (a cache); empty: none.
  std::filesystem::path kept = {};
};

/// Where the job is to write an output until it is whole; an empty path is its own.
using PlaceOf = std::function<std::filesystem::path(const std::filesystem::path& output)>;

/// Runs `job` in a confined child (core/confined.h), which writes below hidden folders beside its outputs and
/// below `kept` only. Once it has succeeded, its outputs get their names: files replace files, folders get
/// what is in them, and nothing else that it made stays; a job that fails, crashes or is cancelled leaves
/// nothing but `kept`. When `progress` (null: nobody's) is cancelled a job with `kept` has ten seconds to end
/// by itself, another one none. What the job prints is printed.
///
/// Errors: the job's, where they name a file that it writes by the output's name; those of run_confined();
/// NotFound where an output's folder is not there; AlreadyExists while another run makes the same; Io.
Result<void> make_confined(const ConfinedOutputs& made, Progress* progress,
                           const std::function<Result<void>(const PlaceOf& place, Progress*)>& job);

}  // namespace floatstage::pipeline
