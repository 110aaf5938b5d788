#pragma once

#include "apps/verbs.h"

namespace floatstage {

// Subcommands of `calibrate`, each in a file of its own.
void add_calibrate_target(CLI::App& calibrate, Chosen& chosen);

}  // namespace floatstage
