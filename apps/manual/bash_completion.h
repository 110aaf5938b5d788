#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace floatstage::apps {

/// A script for bash's programmable completion of the program: its verbs, each verb's options, the words of
/// options that take only these, and paths where a path is wanted. It asks nothing of the program when it
/// runs, and needs no library of scripts. The same tree gives the same bytes.
std::string bash_completion(const CLI::App& program);

}  // namespace floatstage::apps
