#pragma once

#include <filesystem>

#include "core/result.h"

namespace floatstage::pipeline {

/// A stage's folder holds products of one set of options; others need --redo, which clears it. What a person
/// made in it
/// (`keep`) stays. A folder that is not there is clear.
Result<void> clear_for_redo(const std::filesystem::path& folder, const std::filesystem::path& keep = {});

/// Removes half-written files of a run that was killed; finished ones have other names.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
