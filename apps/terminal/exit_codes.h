#pragma once

#include "core/result.h"

namespace floatstage::apps {

constexpr int kExitOk = 0;
constexpr int kExitUsage = 2;     ///< the command line makes no sense
constexpr int kExitBug = 70;      ///< a FLOATSTAGE_CHECK failed: our fault
constexpr int kExitKilled = 130;  ///< interrupted by the user; what was finished is kept

/// The documented exit code of an expected failure (docs/exit-codes.md).
int exit_code(ErrorCode code);

}  // namespace floatstage::apps
