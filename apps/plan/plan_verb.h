#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/terminal/verb.h"

namespace floatstage::apps {

/// Reads a command line, words behind the program's name, into what it chose. BadData with the sentence that
/// a user would have got.
using CommandLineReader = std::function<Result<Chosen>(const std::vector<std::string>& words)>;

/// `plan`: what --plan made of a verb's work. `read`: how an item's process gets at the verb again.
void add_plan(CLI::App& app, Chosen& chosen, CommandLineReader read);

}  // namespace floatstage::apps
