#include "apps/manual/bash_completion.h"

#include "apps/terminal/flags.h"
#include "apps/terminal/joined.h"
#include "apps/terminal/verb_tree.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr const char* kHead = R"(# Completion of floatstage for bash; made from the program's own options.
_floatstage() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} path=floatstage verbs options i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "$path ${COMP_WORDS[i]}" in
)";

constexpr const char* kTail = R"(  if [[ $cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$cur")
  elif [[ $verbs ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$verbs" -- "$cur")
  fi
  [[ ${#COMPREPLY[@]} -gt 0 || $cur == -* ]] || mapfile -t COMPREPLY < <(compgen -f -- "$cur")
}
complete -o filenames -F _floatstage floatstage
)";

// What comes behind an option that takes a value: its words, a path, or something that nobody can guess.
std::string values_line(const std::string& path, const OptionWords& option) {
  std::vector<std::string> patterns;
  for (const std::string& name : option.names) patterns.push_back("\"" + path + " " + name + "\"");
  std::string reply = "return";
  if (!option.values.empty())
    reply =
        text("mapfile -t COMPREPLY < <(compgen -W \"", joined(option.values, " "), "\" -- \"$cur\"); return");
  else if (takes_a_path(option))
    reply = "mapfile -t COMPREPLY < <(compgen -f -- \"$cur\"); return";
  return text("    ", joined(patterns, " | "), ") ", reply, " ;;\n");
}

}  // namespace

std::string bash_completion(const CLI::App& program) {
  std::string paths, values, words;
  for (const CLI::App* verb : verbs_from(program)) {
    const std::string path = path_of(*verb);
    if (verb != &program) paths += text("      \"", path, "\") path=\"", path, "\" ;;\n");
    std::vector<std::string> verbs, options;
    for (const CLI::App* below : verbs_below(*verb)) verbs.push_back(below->get_name());
    for (const std::string& group : option_groups())
      for (const OptionWords& option : options_of(*verb, group)) {
        options.insert(options.end(), option.names.begin(), option.names.end());
        if (!option.type.empty()) values += values_line(path, option);
      }
    words += text("    \"", path, "\") verbs=\"", joined(verbs, " "), "\" options=\"", joined(options, " "),
                  "\" ;;\n");
  }
  return text(kHead, paths, "    esac\n  done\n  case \"$path $prev\" in\n", values,
              "  esac\n  case \"$path\" in\n", words, "  esac\n", kTail);
}

}  // namespace floatstage::apps
