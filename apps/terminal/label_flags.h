#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/chosen_take.h"

namespace floatstage::apps {

/// --label and --without: who of a take's labels is to be seen.
void add_label_choice(CLI::App& verb, pipeline::LabelChoice& choice);

}  // namespace floatstage::apps
