#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// `export`, and its sub-verbs, each of which adds itself.
void add_export(CLI::App& app, Chosen& chosen);
void add_export_colmap(CLI::App& parent, Chosen& chosen);
void add_export_easyvolcap(CLI::App& parent, Chosen& chosen);
void add_export_light_field(CLI::App& parent, Chosen& chosen);
void add_export_mesh(CLI::App& parent, Chosen& chosen);
void add_export_web(CLI::App& parent, Chosen& chosen);

}  // namespace floatstage::apps
