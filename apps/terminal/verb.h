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

/// -h, -q, -v: what the program and every verb have.
void add_flags_of_every_verb(CLI::App& verb, Chosen& chosen);

/// A verb with those flags, and examples at the end of its help. Examples are whole lines that a user may
/// copy: "floatstage render take --orbit -o orbit.mp4" (docs/command-line.md asks for two).
CLI::App* add_verb(CLI::App& parent, Chosen& chosen, const std::string& name, const std::string& help,
                   const std::vector<std::string>& examples);

}  // namespace floatstage::apps
