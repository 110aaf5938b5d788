#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/world.h"

namespace floatstage::apps {

/// --up, --scale, --floor: what a calibration does not say of its world.
void add_world_flags(CLI::App& verb, pipeline::WorldOptions& world);

}  // namespace floatstage::apps
