#pragma once

#include <filesystem>

#include "core/claim.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// The right to write what is derived from a take, for as long as it lives: one job at a time, and none while
/// the take is being recorded. Waits, and says so. NotFound when there is no such folder, Cancelled, Io.
Result<Claim> claim_take(const std::filesystem::path& take, const Progress* progress);

/// Gives a file another place, whole or not at all, and makes the folder; on another file system its bytes
/// are copied, and it is removed. What is at `to` is replaced. Io.
Result<void> move_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Removes half-written files of a run that was killed; finished ones have other names. For those who have
/// claimed the take.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
