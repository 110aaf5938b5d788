#pragma once

#include "apps/terminal/verb.h"

namespace floatstage::apps {

// The verbs that are one file each: they add themselves, with options and help. command_line.cpp lists all.
void add_capture(CLI::App& app, Chosen& chosen);
void add_check(CLI::App& app, Chosen& chosen);
void add_demo(CLI::App& app, Chosen& chosen);
void add_evaluate(CLI::App& app, Chosen& chosen);
void add_flow(CLI::App& app, Chosen& chosen);
void add_hull(CLI::App& app, Chosen& chosen);
void add_import(CLI::App& app, Chosen& chosen);
void add_path(CLI::App& app, Chosen& chosen);
void add_play(CLI::App& app, Chosen& chosen);
void add_process(CLI::App& app, Chosen& chosen);
void add_render(CLI::App& app, Chosen& chosen);
void add_reproduce(CLI::App& app, Chosen& chosen);
void add_synthesize(CLI::App& app, Chosen& chosen);

}  // namespace floatstage::apps
