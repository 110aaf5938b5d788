#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/command_line.h"
#include "apps/manual/bash_completion.h"
#include "apps/manual/man_page.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/verb_tree.h"
#include "core/text.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

struct Tree {
  Chosen chosen;
  std::unique_ptr<CLI::App> app = command_line(chosen);
};

// The words that bash offers behind what somebody has typed; the last word is the unfinished one.
std::set<std::string> offered(const std::string& typed) {
  const Tree tree;
  const TempFolder folder;
  folder.write("script", bash_completion(*tree.app));
  folder.write("take.toml", "");
  const std::string asked =
      text("cd '", folder.path().string(), "' && bash -c '. ./script; COMP_WORDS=(", typed,
           "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _floatstage; "
           "printf \"%s\\n\" \"${COMPREPLY[@]}\"'");
  std::istringstream lines(run_command(asked).output);
  std::set<std::string> words;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) words.insert(line);
  return words;
}

// Hyphens that stay hyphens.
std::string in_troff(std::string name) {
  for (std::size_t at = 0; (at = name.find('-', at)) != std::string::npos; at += 2) name.insert(at, "\\");
  return name;
}

TEST(ManPages, AreOneAVerbAndNameItsOptionsVerbsAndExamples) {
  const Tree tree;
  std::set<std::string> names;
  for (const CLI::App* verb : verbs_from(*tree.app)) {
    const std::string page = man_page(*verb);
    EXPECT_TRUE(names.insert(man_page_name(*verb)).second);
    EXPECT_THAT(page,
                AllOf(HasSubstr(".SH NAME\n"), HasSubstr(".SH SYNOPSIS\n"), HasSubstr(".SH EXAMPLES\n")));
    for (const std::string& group : option_groups())
      for (const OptionWords& option : options_of(*verb, group))
        for (const std::string& name : option.names)
          EXPECT_THAT(page, HasSubstr("\\fB" + in_troff(name) + "\\fR")) << path_of(*verb);
    for (const CLI::App* below : verbs_below(*verb))
      EXPECT_THAT(page, HasSubstr("\\fB" + in_troff(below->get_name()) + "\\fR"));
  }
  EXPECT_THAT(names, AllOf(Contains("floatstage.1"), Contains("floatstage-live-view.1")));
}

TEST(ManPages, AreWhatTroffReadsWithoutAWord) {
  const Tree tree;
  const TempFolder folder;
  for (const CLI::App* verb : verbs_from(*tree.app)) folder.write(man_page_name(*verb), man_page(*verb));
  const std::string all = "'" + folder.path().string() + "'/*.1";
  EXPECT_THAT(run_command("groff -man -Kutf8 -Tutf8 -ww -z " + all).output, IsEmpty());
}

TEST(ManPages, KeepAVerbsTextFromBeingReadAsTroff) {
  CLI::App app("'quoted' .\\word - and\n.TH", "program");
  EXPECT_THAT(man_page(app),
              AllOf(HasSubstr("\\- \\&'quoted' .\\eword \\- and\n\\&.TH"), Not(HasSubstr("\n.TH\n"))));
}

TEST(BashCompletion, OffersVerbsAndTheirVerbs) {
  EXPECT_THAT(offered("floatstage pro"), testing::ElementsAre("process"));
  EXPECT_THAT(offered("floatstage take tr"), testing::ElementsAre("trim"));
}

TEST(BashCompletion, OffersTheOptionsOfTheVerbThatWasTyped) {
  EXPECT_THAT(offered("floatstage render take --orb"), testing::ElementsAre("--orbit"));
  EXPECT_THAT(offered("floatstage keys --orb"), IsEmpty());
}

TEST(BashCompletion, OffersTheWordsOfAnOptionAndPathsWhereTheyBelong) {
  EXPECT_THAT(offered("floatstage render take --show soft"), testing::ElementsAre("soft-visibility"));
  EXPECT_THAT(offered("floatstage render ta"), testing::ElementsAre("take.toml"));
  EXPECT_THAT(offered("floatstage render take -o ta"), testing::ElementsAre("take.toml"));
  EXPECT_THAT(offered("floatstage render take --fps ta"), IsEmpty()) << "nobody can guess a number";
}

}  // namespace
}  // namespace floatstage::apps
