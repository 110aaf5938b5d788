#pragma once

#include <CLI/CLI.hpp>

#include "core/result.h"
#include "pipeline/orbit.h"

namespace floatstage::apps {

/// --height, --distance, --fov, --turns, --start of a walk around the stage, the same for every verb that
/// has one. `walk`, where it is given, is the flag that they need beside them.
void add_orbit_flags(CLI::App& verb, pipeline::OrbitOptions& orbit, CLI::Option* walk);

}  // namespace floatstage::apps
