#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/result.h"

namespace floatstage::apps {

/// What the command line chose: one verb's callback fills it while parsing, main() runs it afterwards.
struct Chosen {
  std::function<Result<void>()> run;
  bool quiet = false, verbose = false;
};

/// A verb with what every verb has: -h, -q, -v, and examples at the end of its help. Examples are whole lines
/// that a user may copy: "floatstage render take --orbit -o orbit.mp4" (docs/command-line.md asks for two).
CLI::App* add_verb(CLI::App& parent, Chosen& chosen, const std::string& name, const std::string& help,
                   const std::vector<std::string>& examples);

// One function a verb: adds its subcommand with options and help. The table in command_line.cpp lists them.
void add_demo(CLI::App& app, Chosen& chosen);
void add_calibrate(CLI::App& app, Chosen& chosen);
void add_capture(CLI::App& app, Chosen& chosen);
void add_check(CLI::App& app, Chosen& chosen);
void add_detail(CLI::App& app, Chosen& chosen);
void add_synthesize(CLI::App& app, Chosen& chosen);
void add_import(CLI::App& app, Chosen& chosen);
void add_take_verb(CLI::App& app, Chosen& chosen);
void add_matte(CLI::App& app, Chosen& chosen);
void add_matte_image(CLI::App& app, Chosen& chosen);
void add_hull(CLI::App& app, Chosen& chosen);
void add_keys(CLI::App& app, Chosen& chosen);
void add_process(CLI::App& app, Chosen& chosen);
void add_render(CLI::App& app, Chosen& chosen);
void add_evaluate(CLI::App& app, Chosen& chosen);
void add_export(CLI::App& app, Chosen& chosen);
void add_flow(CLI::App& app, Chosen& chosen);
void add_live(CLI::App& app, Chosen& chosen);
void add_live_recon(CLI::App& live, Chosen& chosen);
void add_live_view(CLI::App& live, Chosen& chosen);
void add_play(CLI::App& app, Chosen& chosen);

}  // namespace floatstage::apps
