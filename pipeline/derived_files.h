#pragma once

#include <filesystem>

#include "core/claim.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// The right to write what is derived from a take, for as long as it lives: one job at a time, and none while
/// the take is being recorded. Waits, and says so. NotFound when there is no such folder, Cancelled, Io.
Result<Claim> claim_take(const std::filesystem::path& take, const Progress* progress);

/// Removes half-written files of a run that was killed; finished ones have other names. For those who have
/// claimed the take.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
