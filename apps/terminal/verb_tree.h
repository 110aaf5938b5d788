#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace floatstage::apps {

/// What manual pages and completion say of an option, read from the tree of verbs and from nowhere else.
struct OptionWords {
  std::vector<std::string> names;   ///< "-o", "--out"; empty for a word without a flag
  std::string word;                 ///< of a word without a flag: "take"
  std::string type;                 ///< "PATH", "N", "TEXT"; empty for a flag
  std::vector<std::string> values;  ///< the words that it takes, where there are only these
  std::string usual;                ///< its value where nothing is said; may be empty
  std::string help;
  bool required = false;
};

/// The verbs right below, in the order of the help page.
std::vector<const CLI::App*> verbs_below(const CLI::App& app);
/// `app` and every verb below it, parents before their verbs.
std::vector<const CLI::App*> verbs_from(const CLI::App& app);
/// "floatstage live view".
std::string path_of(const CLI::App& app);

/// The words without a flag, in their order.
std::vector<OptionWords> positionals_of(const CLI::App& verb);
/// The options of one group of the help page, in their order.
std::vector<OptionWords> options_of(const CLI::App& verb, const std::string& group);

/// Whether its value is a file or a folder.
bool takes_a_path(const OptionWords& option);

}  // namespace floatstage::apps
