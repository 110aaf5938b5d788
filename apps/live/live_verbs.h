#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// `live`, and its sub-verbs that have files of their own.
void add_live(CLI::App& app, Chosen& chosen);
void add_live_recon(CLI::App& live, Chosen& chosen);
void add_live_view(CLI::App& live, Chosen& chosen);

}  // namespace floatstage::apps
