#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// `calibrate`.
void add_calibrate(CLI::App& app, Chosen& chosen);

// `calibrate SESSION` and its subcommands, each in a file of its own.
void add_calibrate_session(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_color(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_drift(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_export(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_live(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_new(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_silhouettes(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_target(CLI::App& calibrate, Chosen& chosen);
void add_calibrate_times(CLI::App& calibrate, Chosen& chosen);

}  // namespace floatstage::apps
