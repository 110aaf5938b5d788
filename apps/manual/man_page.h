#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace floatstage::apps {

/// The name of a verb's page, without folder: "floatstage-live-view.1".
std::string man_page_name(const CLI::App& verb);

/// The page of a verb, or of the program, in the man macros of troff (groff_man(7)), as UTF-8: what its
/// `--help` says, in the order of its groups, with its verbs and the pages to read next. The same tree gives
/// the same bytes: there is no date.
std::string man_page(const CLI::App& verb);

}  // namespace floatstage::apps
