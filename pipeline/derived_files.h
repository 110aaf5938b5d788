#pragma once

#include <filesystem>

namespace floatstage::pipeline {

/// Removes half-written files of a run that was killed; finished ones have other names.
void sweep_temporaries(const std::filesystem::path& folder);

}  // namespace floatstage::pipeline
