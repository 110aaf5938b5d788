#pragma once

#include "apps/verbs.h"

namespace floatstage::apps {

// The sub-verbs of `export`, each of which adds itself.
void add_export_colmap(CLI::App& parent, Chosen& chosen);
void add_export_mesh(CLI::App& parent, Chosen& chosen);
void add_export_web(CLI::App& parent, Chosen& chosen);
void add_export_mesh(CLI::App& parent, Chosen& chosen);

}  // namespace floatstage::apps
