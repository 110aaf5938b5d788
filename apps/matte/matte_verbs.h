#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

// The verbs that make mattes, and one that shows what keys see.
void add_keys(CLI::App& app, Chosen& chosen);
void add_matte(CLI::App& app, Chosen& chosen);
void add_matte_image(CLI::App& app, Chosen& chosen);

}  // namespace floatstage::apps
