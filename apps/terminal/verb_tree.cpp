#include "apps/terminal/verb_tree.h"

#include <set>
#include <sstream>

namespace floatstage::apps {
namespace {

// "TEXT:{color,weights}" is a type with the words it may be.
void read_type(const std::string& name, OptionWords& words) {
  const std::size_t open = name.find(":{");
  words.type = name.substr(0, open);
  if (open == std::string::npos) return;
  std::istringstream values(name.substr(open + 2, name.rfind('}') - open - 2));
  for (std::string value; std::getline(values, value, ',');) words.values.push_back(value);
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords words;
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  if (option.get_positional()) words.word = option.get_name();
  if (option.get_type_size() != 0) read_type(option.get_type_name(), words);
  words.usual = option.get_default_str();
  words.help = option.get_description();
  words.required = option.get_required();
  return words;
}

}  // namespace

std::vector<const CLI::App*> verbs_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::App*> verbs_from(const CLI::App& app) {
  std::vector<const CLI::App*> verbs = {&app};
  for (const CLI::App* verb : verbs_below(app))
    for (const CLI::App* each : verbs_from(*verb)) verbs.push_back(each);
  return verbs;
}

std::string path_of(const CLI::App& app) {
  return app.get_parent() ? path_of(*app.get_parent()) + " " + app.get_name() : app.get_name();
}

std::vector<OptionWords> positionals_of(const CLI::App& verb) {
  std::vector<OptionWords> words;
  for (const CLI::Option* option : verb.get_options())
    if (option->get_positional()) words.push_back(words_of(*option));
  return words;
}

std::vector<OptionWords> options_of(const CLI::App& verb, const std::string& group) {
  std::vector<OptionWords> words;
  for (const CLI::Option* option : verb.get_options())
    if (option->nonpositional() && option->get_group() == group) words.push_back(words_of(*option));
  return words;
}

bool takes_a_path(const OptionWords& option) {
  static const std::set<std::string> paths = {"PATH", "FILE", "FOLDER", "TAKE", "TEXT"};
  return paths.contains(option.type) && option.values.empty();
}

}  // namespace floatstage::apps
