#include "apps/command_line.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/detail/detail_verbs.h"
#include "apps/export/export_verbs.h"
#include "apps/live/live_verbs.h"
#include "apps/matte/matte_verbs.h"
#include "apps/plan/plan_verb.h"
#include "apps/take/take_verbs.h"
#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/exit_codes.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/verb_tree.h"
#include "apps/verbs.h"
#include "apps/version.h"
#include "core/file_presence.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

constexpr std::size_t kHelpColumn = 32, kHelpWidth = 110;

// Lines of at most `width` columns; breaks that are there already stay.
std::string wrapped(const std::string& sentence, std::size_t width) {
  std::string out;
  std::istringstream lines(sentence);
  for (std::string line; std::getline(lines, line);) {
    if (!out.empty()) out += '\n';
    std::size_t column = line.find_first_not_of(' ');
    if (column == std::string::npos) continue;
    const std::string indent(column + (column > 0 ? 2 : 0), ' ');
    out += line.substr(0, column);
    std::istringstream words(line);
    bool first = true;
    for (std::string word; words >> word; first = false) {
      if (!first && column + 1 + word.size() > width) {
        out += "\n" + indent;
        column = indent.size();
      } else if (!first) {
        out += ' ';
        ++column;
      }
      out += word;
      column += word.size();
    }
  }
  return out;
}

// Groups in our order, whatever the order in which a verb adds its options; long sentences in lines.
class HelpPage final : public CLI::Formatter {
 public:
  HelpPage() {
    column_width(kHelpColumn);
    label("SUBCOMMAND", "VERB");
  }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::Sub) return Formatter::make_help(app, std::move(name), mode);
    std::string out = make_description(app) + make_usage(app, std::move(name)) + make_positionals(app);
    for (const std::string& group : option_groups()) {
      const std::vector<const CLI::Option*> options = app->get_options(
          [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
      if (!options.empty()) out += make_group(group, false, options);
    }
    return out + make_subcommands(app, mode) + "\n" + make_footer(app);
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), kHelpWidth - kHelpColumn);
  }
};

std::vector<std::string> names_of(const std::vector<const CLI::App*>& verbs) {
  std::vector<std::string> names;
  for (const CLI::App* verb : verbs) names.push_back(verb->get_name());
  return names;
}

bool takes_words(const CLI::App& app) {
  return !app.get_options([](const CLI::Option* option) { return option->get_positional(); }).empty();
}

// CLI11 only says that a subcommand is required; a user wants to know which word was wrong.
std::string unknown_verb(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* at = &app;
  for (const std::string& word : words) {
    if (word.starts_with("-")) {
      if (at == &app) continue;  // the program's own options are flags
      return "";
    }
    const std::vector<const CLI::App*> verbs = verbs_below(*at);
    if (verbs.empty()) return "";
    const std::vector<std::string> names = names_of(verbs);
    if (const auto found = std::find(names.begin(), names.end(), word); found != names.end()) {
      at = verbs[static_cast<std::size_t>(found - names.begin())];
      continue;
    }
    const std::string meant = did_you_mean(word, names);
    // A word of the verb itself, unless it is a verb with a slip and no file.
    if (takes_words(*at) &&
        (meant.empty() || word.find_first_of("./") != std::string::npos || is_there(word)))
      return "";
    std::string all;
    for (const std::string& name : names) all += " " + name;
    return text(path_of(*at), ": there is no verb '", word, "'", meant.empty() ? "; " : meant + " ",
                meant.empty() ? "there are:" : "There are:", all);
  }
  return "";
}

// The same thing in other verbs, in other programs, and in this one before.
constexpr std::array<std::pair<const char*, const char*>, 15> kSynonyms = {{{"--cameras", "--camera-count"},
                                                                            {"--cameras", "--blend"},
                                                                            {"--frames", "--frame-count"},
                                                                            {"--method", "--methods"},
                                                                            {"--method", "--matte"},
                                                                            {"--method", "--hull"},
                                                                            {"--key", "--matte"},
                                                                            {"--matte-method", "--matte"},
                                                                            {"--output", "--out"},
                                                                            {"--output", "--show"},
                                                                            {"--jobs", "--threads"},
                                                                            {"--report", "--json"},
                                                                            {"--silent", "--quiet"},
                                                                            {"--force", "--redo"},
                                                                            {"--overwrite", "--redo"}}};

std::string unknown_option(const CLI::App& verb, const std::string& typed) {
  const std::string word = typed.substr(0, typed.find('='));
  std::vector<std::string> known;
  for (const CLI::Option* option : verb.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    for (const std::string& name : option->get_snames()) known.push_back("-" + name);
  }
  const auto has = [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  std::string meant;
  for (const CLI::App* sub : verbs_below(verb))
    if (word == "--" + sub->get_name()) meant = text("; it is a verb: `", path_of(*sub), "`");
  for (const auto& [from, to] : kSynonyms)
    if (meant.empty() && word == from && has(to)) meant = text("; did you mean '", to, "'?");
  if (meant.empty()) meant = did_you_mean(word, known);
  return text(path_of(verb), " has no option ", word, meant, meant.ends_with("?") ? " See" : "; see", " `",
              path_of(verb), " --help`");
}

const CLI::App& chosen_verb(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

Ending explained(const CLI::App& app, const CLI::ParseError& e) {
  const CLI::App& verb = chosen_verb(app);
  const std::vector<std::string> left_over = app.remaining(true);
  for (const std::string& word : left_over)
    if (word.size() > 1 && word[0] == '-') return {kExitUsage, "", unknown_option(verb, word)};
  const bool value = dynamic_cast<const CLI::ValidationError*>(&e) != nullptr ||
                     dynamic_cast<const CLI::ConversionError*>(&e) != nullptr;
  if (value) return {exit_code(ErrorCode::InvalidArgument), "", text(path_of(verb), ": ", e.what())};
  const std::string see = text("; see `", path_of(verb), " --help`");
  if (verb.get_parent() == nullptr ||
      (!takes_words(verb) && !verbs_below(verb).empty() && left_over.empty())) {
    std::string all;
    for (const std::string& name : names_of(verbs_below(verb))) all += " " + name;
    return {kExitUsage, "", text(path_of(verb), ": say what is to be done:", all, see)};
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&e) != nullptr && !left_over.empty())
    return {kExitUsage, "", text(path_of(verb), ": '", left_over.front(), "' is a word too many", see)};
  return {kExitUsage, "", text(path_of(verb), ": ", e.what(), see)};
}

// How plans read the command line that they were made of.
Result<Chosen> chosen_by(const std::vector<std::string>& words) {
  Chosen chosen;
  const std::unique_ptr<CLI::App> app = command_line(chosen);
  if (const std::optional<Ending> ending = read_command_line(*app, words))
    return fail(ErrorCode::BadData, ending->error);
  return chosen;
}

}  // namespace

std::unique_ptr<CLI::App> command_line(Chosen& chosen) {
  auto app = std::make_unique<CLI::App>(
      "Floatstage: a multiview capture-and-playback studio with Floating Textures", "floatstage");
  app->formatter(std::make_shared<HelpPage>());
  add_flags_of_every_verb(*app, chosen);
  app->set_version_flag("--version", std::string("floatstage ") + kVersion)->group(kGroupRun);
  app->footer(
      "Every verb explains itself: floatstage VERB --help\nExamples:\n  floatstage demo -o demo\n"
      "  floatstage render --help");
  for (auto add :
       {add_demo,      add_capture,     add_check, add_calibrate, add_synthesize, add_import, add_take_verb,
        add_matte,     add_matte_image, add_hull,  add_keys,      add_process,    add_render, add_evaluate,
        add_reproduce, add_export,      add_path,  add_detail,    add_flow,       add_live,   add_play})
    add(*app, chosen);
  add_plan(*app, chosen, chosen_by);
  app->require_subcommand(1);
  return app;
}

std::optional<Ending> read_command_line(CLI::App& app, const std::vector<std::string>& words) {
  if (const std::string fault = unknown_verb(app, words); !fault.empty())
    return Ending{kExitUsage, "", fault};
  std::vector<std::string> reversed(words.rbegin(), words.rend());
  try {
    app.parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    return Ending{kExitOk, app.help(), ""};
  } catch (const CLI::CallForVersion& e) {
    return Ending{kExitOk, std::string(e.what()) + "\n", ""};
  } catch (const CLI::ParseError& e) {
    return explained(app, e);
  }
  return std::nullopt;
}

}  // namespace floatstage::apps
