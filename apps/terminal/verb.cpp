#include "apps/terminal/verb.h"

#include "apps/terminal/flags.h"

namespace floatstage::apps {

void add_flags_of_every_verb(CLI::App& verb, Chosen& chosen) {
  verb.set_help_flag("-h,--help", "Print this help and end")->group(kGroupRun);
  verb.add_flag("-q,--quiet", chosen.quiet, "Only warnings and errors")->group(kGroupRun);
  verb.add_flag("-v,--verbose", chosen.verbose, "Debug messages too")->group(kGroupRun);
}

CLI::App* add_verb(CLI::App& parent, Chosen& chosen, const std::string& name, const std::string& help,
                   const std::vector<std::string>& examples) {
  CLI::App* verb = parent.add_subcommand(name, help);
  add_flags_of_every_verb(*verb, chosen);
  verb->group("Verbs");
  std::string footer = "Examples:";
  for (const std::string& example : examples) footer += "\n  " + example;
  verb->footer(footer);
  return verb;
}

}  // namespace floatstage::apps
