#pragma once

#include "apps/verbs.h"

namespace floatstage::apps {

/// `plan`: what --plan made of a verb's work.
void add_plan(CLI::App& app, Chosen& chosen);

}  // namespace floatstage::apps
