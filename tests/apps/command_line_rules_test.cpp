#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/command_line.h"
#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/exit_codes.h"
#include "apps/terminal/flags.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"

// docs/command-line.md states the rules; here every verb is held to them.
namespace floatstage::apps {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

struct Tree {
  Chosen chosen;
  std::unique_ptr<CLI::App> app = command_line(chosen);

  std::optional<Ending> read(const std::string& line) {
    std::vector<std::string> words;
    bool quoted = false, open = false;
    for (const char c : line) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ' ' && !quoted) {
        open = false;
      } else {
        if (!open) words.emplace_back();
        open = true;
        words.back() += c;
      }
    }
    return read_command_line(*app, words);
  }
};

std::vector<const CLI::App*> children(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

void collect(const CLI::App& app, const std::string& name, std::map<std::string, const CLI::App*>& verbs) {
  for (const CLI::App* verb : children(app)) {
    const std::string whole = name + (name.empty() ? "" : " ") + verb->get_name();
    verbs[whole] = verb;
    collect(*verb, whole, verbs);
  }
}

// "live view" and so on. `import` alone does nothing; its verbs do.
std::map<std::string, const CLI::App*> verbs_of(const Tree& tree) {
  std::map<std::string, const CLI::App*> verbs;
  collect(*tree.app, "", verbs);
  return verbs;
}

bool works(const CLI::App& verb) { return children(verb).empty() || verb.get_require_subcommand_min() == 0; }

std::map<std::string, const CLI::Option*> options_of(const CLI::App& verb) {
  std::map<std::string, const CLI::Option*> options;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) options[name] = option;
  return options;
}

std::vector<std::string> examples_of(const CLI::App& verb) {
  std::istringstream lines(verb.get_footer());
  std::vector<std::string> examples;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("  floatstage ")) examples.push_back(line.substr(13));
  return examples;
}

TEST(EveryVerb, CanBeReadAboutAndSilenced) {
  const Tree tree;
  for (const auto& [name, verb] : verbs_of(tree)) {
    const auto options = options_of(*verb);
    for (const auto& [word, letter] : {std::pair{"help", "h"}, {"quiet", "q"}, {"verbose", "v"}}) {
      ASSERT_TRUE(options.contains(word)) << name << " --" << word;
      EXPECT_THAT(options.at(word)->get_snames(), testing::ElementsAre(letter)) << name;
    }
    EXPECT_THAT(verb->get_description(), testing::Not(IsEmpty())) << name;
    for (const CLI::Option* option : verb->get_options())
      EXPECT_THAT(option->get_description(), testing::Not(IsEmpty())) << name << " " << option->get_name();
  }
}

TEST(EveryVerb, ThatWorksReportsAsJson) {
  const Tree tree;
  for (const auto& [name, verb] : verbs_of(tree)) {
    if (!works(*verb)) continue;
    EXPECT_TRUE(options_of(*verb).contains("json")) << name;
  }
}

TEST(EveryVerb, MeansTheSameByTheSameWord) {
  const Tree tree;
  // Of a name: its short form, what it takes, and its group. One and the same wherever it stands.
  const std::set<std::string> shared = {
      "out",         "json",   "threads",     "cameras", "camera-count",   "frames",
      "frame-count", "size",   "fps",         "seconds", "blend",          "hull",
      "votes",       "volume", "codec",       "smooth",  "cleanup-pixels", "cleanup-loss",
      "triangles",   "nodes",  "soft-radius", "flow",    "resolution",     "show",
      "redo",        "rig",    "frame",       "matte",   "guide"};
  std::map<std::string, std::string> meaning;
  for (const auto& [name, verb] : verbs_of(tree))
    for (const auto& [word, option] : options_of(*verb)) {
      if (!shared.contains(word)) continue;
      const std::string letter = option->get_snames().empty() ? "" : option->get_snames().front();
      const std::string here = text("-", letter, " ", option->get_type_name());
      const std::string first = meaning.try_emplace(word, here).first->second;
      EXPECT_EQ(here, first) << name << " --" << word;
    }
  EXPECT_EQ(meaning.at("out"), "-o PATH");
  EXPECT_EQ(meaning.at("threads"), "-j N");
  EXPECT_EQ(meaning.at("cameras"), "- A,B,C") << "serials";
  EXPECT_EQ(meaning.at("frames"), "- A:B[:STEP]") << "a range";
  EXPECT_EQ(meaning.at("size"), "- WxH");
  EXPECT_EQ(meaning.at("blend"), "- K");
}

TEST(EveryVerb, ThatBlendsPhotographsOrMakesHullsHasTheWordsForThem) {
  const Tree tree;
  const auto verbs = verbs_of(tree);
  for (const char* name : {"render", "evaluate", "play", "live", "live view", "demo"})
    EXPECT_TRUE(options_of(*verbs.at(name)).contains("blend")) << name;
  std::set<std::string> defaults;
  for (const char* name : {"process", "hull", "evaluate"}) {
    const auto options = options_of(*verbs.at(name));
    defaults.insert(options.at("hull")->get_default_str() + " " + options.at("votes")->get_default_str());
  }
  EXPECT_THAT(defaults, testing::ElementsAre("exact auto"));
}

TEST(EveryVerb, HasItsOptionsInTheGroupsThatThereAre) {
  const Tree tree;
  const std::vector<std::string> groups = option_groups();
  EXPECT_EQ(groups.front(), "Options");
  EXPECT_EQ(groups.back(), "Tuning");
  for (const auto& [name, verb] : verbs_of(tree)) {
    for (const CLI::Option* option : verb->get_options())
      EXPECT_THAT(groups, testing::Contains(option->get_group())) << name << " " << option->get_name();
    const std::string help = verb->help();
    std::size_t at = 0;
    for (const std::string& group : groups)
      if (const std::size_t here = help.find("\n" + group + ":\n"); here != std::string::npos) {
        EXPECT_GT(here, at) << name << ": " << group;
        at = here;
      }
  }
}

TEST(EveryVerb, EndsItsHelpWithTwoExamplesThatItUnderstands) {
  const Tree tree;
  for (const auto& [name, verb] : verbs_of(tree)) {
    const std::vector<std::string> examples = examples_of(*verb);
    EXPECT_THAT(examples, SizeIs(2)) << name;
    for (const std::string& example : examples) {
      EXPECT_EQ(example.rfind(name, 0), 0u) << name << ": " << example;
      EXPECT_THAT(verb->help(), HasSubstr("  floatstage " + example + "\n"));
      Tree fresh;
      const std::optional<Ending> ending = fresh.read(example);
      EXPECT_FALSE(ending) << example << ": " << ending->error;
      EXPECT_TRUE(fresh.chosen.run) << example;
    }
  }
}

TEST(EveryVerb, SaysWhichOptionWasMeant) {
  const Tree whole;
  for (const auto& [name, verb] : verbs_of(whole)) {
    if (!works(*verb)) continue;
    for (const auto& [word, option] : options_of(*verb)) {
      if (word.size() < 5) continue;
      std::string slip = word;
      std::swap(slip[word.size() - 2], slip[word.size() - 3]);
      if (slip == word || options_of(*verb).contains(slip)) continue;
      Tree tree;
      const std::optional<Ending> ending = tree.read(name + " --" + slip + " 1");
      ASSERT_TRUE(ending) << name << " --" << slip;
      EXPECT_EQ(ending->code, kExitUsage) << name << " --" << slip;
      EXPECT_THAT(ending->error, AllOf(HasSubstr("--" + slip), HasSubstr("'--" + word + "'")));
    }
  }
}

TEST(EveryVerb, StandsInTheReadme) {
  const Result<std::string> readme = read_file(source_folder() / "README.md");
  ASSERT_THAT(readme, IsOk());
  const Tree whole;
  for (const auto& [name, verb] : verbs_of(whole)) {
    if (name.starts_with("import ")) continue;
    EXPECT_THAT(*readme, HasSubstr("| `" + name + "` |"));
  }
}

std::string error_of(const std::string& line, int code = kExitUsage) {
  Tree tree;
  const std::optional<Ending> ending = tree.read(line);
  if (!ending) return "understood";
  EXPECT_EQ(ending->code, code) << line << ": " << ending->error;
  return ending->error;
}

TEST(ASlip, InAVerbIsMended) {
  EXPECT_THAT(error_of("rendr take"), AllOf(HasSubstr("'rendr'"), HasSubstr("did you mean 'render'?")));
  EXPECT_THAT(error_of("-q procces take"), HasSubstr("did you mean 'process'?"));
  EXPECT_THAT(error_of("live veiw tcp://a:1"), HasSubstr("did you mean 'view'?"));
  EXPECT_THAT(error_of("calibrate tagret charuco"), HasSubstr("did you mean 'target'?"));
  EXPECT_THAT(error_of("import colmpa model"), HasSubstr("did you mean 'colmap'?"));
  EXPECT_THAT(error_of("xyzzy"), AllOf(HasSubstr("'xyzzy'"), HasSubstr("there are: demo")));
  EXPECT_EQ(error_of("calibrate session.toml"), "understood") << "a word of its own";
}

TEST(ASlip, InAValueIsMended) {
  const int code = exit_code(ErrorCode::InvalidArgument);
  EXPECT_THAT(error_of("render take --orbit -o a.mp4 --method floting", code),
              AllOf(HasSubstr("'floting'"), HasSubstr("did you mean 'floating'?")));
  EXPECT_THAT(error_of("hull take --hull exat", code), HasSubstr("did you mean 'exact'?"));
  EXPECT_THAT(error_of("matte take --matte spectal", code), HasSubstr("did you mean 'spectral'?"));
  EXPECT_THAT(error_of("synthesize -o take --size 640*480", code), HasSubstr("640x480"));
  EXPECT_THAT(error_of("render take --show wieghts", code), HasSubstr("did you mean 'weights'?"));
}

// What had other names before, and has others in other programs.
TEST(AnOldWord, LeadsToTheNewOne) {
  const std::vector<std::pair<std::string, std::string>> words = {
      {"render take --cameras 4", "'--blend'"},
      {"play take --cameras 4", "'--blend'"},
      {"live --source take --cameras 4", "'--blend'"},
      {"synthesize -o take --cameras 4", "'--camera-count'"},
      {"demo --cameras 4", "'--camera-count'"},
      {"demo --frames 4", "'--frame-count'"},
      {"synthesize -o take --frames 4", "'--frame-count'"},
      {"calibrate color take --frames 4", "'--frame-count'"},
      {"live --source take --out-size 640x480", "'--size'"},
      {"live --recon tcp://a:1 --nodes tcp://b:2", "`floatstage live recon`"},
      {"live --view tcp://a:1", "`floatstage live view`"},
      {"hull take --method octree", "'--hull'"},
      {"process take --key chroma", "'--matte'"},
      {"live --source take --key chroma", "'--matte'"},
      {"process take --method spectral", "'--matte'"},
      {"matte take --method auto", "'--matte'"},
      {"matte-image a.png -o b.png --method spectral", "'--matte'"},
      {"play take --matte-method chroma", "'--matte'"},
      {"process take --care-pixels 1", "'--cleanup-pixels'"},
      {"hull take --care-loss 1", "'--cleanup-loss'"},
      {"evaluate take --output weights", "'--show'"},
      {"render take --output a.mp4", "'--out'"},
      {"process take --jobs 4", "'--threads'"}};
  for (const auto& [line, word] : words) EXPECT_THAT(error_of(line), HasSubstr(word)) << line;
}

TEST(LiveRecon, NeedsItsNodesAndItsRig) {
  EXPECT_THAT(error_of("live recon tcp://a:1"), HasSubstr("--nodes"));
  EXPECT_THAT(error_of("live recon tcp://a:1 --nodes tcp://b:2"), HasSubstr("--rig"));
  EXPECT_THAT(error_of("live view tcp://a:1 --nodes tcp://b:2 --rig r.json --source take"),
              HasSubstr("has no option --source"));
}

TEST(Closest, FindsWhatFingersMeant) {
  const std::vector<std::string> words = {"--size", "--seconds", "--screenshot"};
  EXPECT_EQ(closest("--sise", words), "--size");
  EXPECT_EQ(closest("--szie", words), "--size");
  EXPECT_EQ(closest("--SIZE", words), "--size");
  EXPECT_EQ(closest("--second", words), "--seconds");
  EXPECT_EQ(closest("--out-size", words), "--size");
  EXPECT_EQ(closest("--background", words), "");
  EXPECT_EQ(closest("", words), "");
  EXPECT_EQ(closest("x", {}), "");
}

}  // namespace
}  // namespace floatstage::apps
