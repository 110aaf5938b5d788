#pragma once

#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/matte/heal_mattes.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Compares the mattes of each of these instants with the hull of all of them, and makes those of ours anew
/// that the others contradict (MatteHealer), as `process` does with the hulls that it makes: the mattes are
/// then the same, whichever comes first. Instants of which nothing is ours, with fewer than three mattes, or
/// compared before cost no hull. In parallel; the same result at any number of threads. Worst camera first.
/// Errors: those of MatteHealer; Cancelled.
Result<std::vector<HealedCamera>> heal_take(capture::TakeReader& take, const std::vector<int>& frames,
                                            int threads, Progress* watch = nullptr);

}  // namespace floatstage::pipeline
