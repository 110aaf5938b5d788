#include "apps/manual/man_page.h"

#include <algorithm>
#include <sstream>

#include "apps/terminal/flags.h"
#include "apps/terminal/joined.h"
#include "apps/terminal/verb_tree.h"
#include "apps/version.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

// Text that troff takes for nothing else: no escapes, no requests at the beginning of a line, hyphens that
// can be copied.
std::string plain(const std::string& words) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool begins = i == 0 || words[i - 1] == '\n';
    if (begins && (words[i] == '.' || words[i] == '\'')) out += "\\&";
    if (words[i] == '\\')
      out += "\\e";
    else if (words[i] == '-')
      out += "\\-";
    else
      out += words[i];
  }
  return out;
}

std::string bold(const std::string& words) { return "\\fB" + plain(words) + "\\fR"; }
std::string slanted(const std::string& words) { return "\\fI" + plain(words) + "\\fR"; }

// Sentences; where the help page begins a line of its own, so does this one.
std::string sentences(const std::string& help) {
  std::string out;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t column = line.find_first_not_of(' ');
    if (column == std::string::npos) continue;
    if (!out.empty()) out += ".br\n";
    out += plain(line.substr(column)) + "\n";
  }
  return out;
}

std::string entry(const OptionWords& option) {
  constexpr std::size_t kLine = 60;  // columns that a tag may take: it is never broken
  const bool many = joined(option.values, "|").size() > kLine;
  std::string out = ".TP\n";
  for (const std::string& name : option.names) out += (out.ends_with("\n") ? "" : ", ") + bold(name);
  if (option.names.empty()) out += slanted(option.word);
  const std::string value = option.values.empty() || many ? option.type : joined(option.values, "|");
  if (!option.names.empty() && !value.empty()) out += " " + slanted(value);
  out += "\n" + sentences(option.help);
  if (many) out += text(".br\nOne of: ", plain(joined(option.values, ", ")), "\n");
  if (!option.usual.empty()) out += text(".br\nWithout it: ", plain(option.usual), "\n");
  return out;
}

std::string synopsis(const CLI::App& verb) {
  std::string out = ".SH SYNOPSIS\n" + bold(path_of(verb));
  if (!verbs_below(verb).empty()) {
    const bool alone = verb.get_require_subcommand_min() == 0;
    out += " " + (alone ? "[" + slanted("VERB") + "]" : slanted("VERB"));
  }
  for (const OptionWords& word : positionals_of(verb))
    out += " " + (word.required ? slanted(word.word) : "[" + slanted(word.word) + "]");
  for (const std::string& group : option_groups())
    for (const OptionWords& option : options_of(verb, group))
      if (option.required) out += " " + bold(option.names.back()) + " " + slanted(option.type);
  return out + " [" + slanted("OPTIONS") + "]\n";
}

std::string verbs_section(const CLI::App& verb) {
  if (verbs_below(verb).empty()) return "";
  std::string out = ".SH VERBS\n";
  for (const CLI::App* below : verbs_below(verb))
    out += text(".TP\n", bold(below->get_name()), "\n", sentences(below->get_description()));
  return out;
}

std::string options_sections(const CLI::App& verb) {
  std::string out;
  const std::vector<OptionWords> words = positionals_of(verb);
  if (!words.empty()) out += ".SH WORDS\n";
  for (const OptionWords& word : words) out += entry(word);
  for (const std::string& group : option_groups()) {
    const std::vector<OptionWords> options = options_of(verb, group);
    if (options.empty()) continue;
    std::string title = group;
    std::transform(title.begin(), title.end(), title.begin(), ::toupper);
    out += ".SH " + plain(title) + "\n";
    for (const OptionWords& option : options) out += entry(option);
  }
  return out;
}

std::string examples_section(const CLI::App& verb) {
  std::string out;
  std::istringstream lines(verb.get_footer());
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  ")) out += plain(line.substr(2)) + "\n";
  return out.empty() ? "" : ".SH EXAMPLES\n.nf\n" + out + ".fi\n";
}

std::string see_also(const CLI::App& verb) {
  std::vector<const CLI::App*> others = verbs_below(verb);
  if (verb.get_parent() != nullptr) others.insert(others.begin(), verb.get_parent());
  std::string out;
  for (const CLI::App* other : others) {
    const std::string name = man_page_name(*other);
    out += (out.empty() ? "" : ",\n") + bold(name.substr(0, name.size() - 2)) + "(1)";
  }
  return ".SH SEE ALSO\n" + out + "\n";
}

}  // namespace

std::string man_page_name(const CLI::App& verb) {
  std::string name = path_of(verb);
  std::replace(name.begin(), name.end(), ' ', '-');
  return name + ".1";
}

std::string man_page(const CLI::App& verb) {
  const std::string name = man_page_name(verb), title = name.substr(0, name.size() - 2);
  std::string capitals = title;
  std::transform(capitals.begin(), capitals.end(), capitals.begin(), ::toupper);
  return text(".TH ", plain(capitals), " 1 \"\" \"floatstage ", plain(kVersion), "\" Floatstage\n",
              ".SH NAME\n", plain(title), " \\- ", plain(verb.get_description()), "\n", synopsis(verb),
              verbs_section(verb), options_sections(verb), examples_section(verb),
              ".SH EXIT STATUS\n0 when it is done. Any other number comes with a sentence on standard error "
              "and stands in\nexit\\-codes.md of the documentation.\n",
              see_also(verb));
}

}  // namespace floatstage::apps
