// Reads the project's own documents: a link that leads nowhere sends a reader away.

#include <filesystem>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/document_links.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"

namespace floatstage::architecture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

namespace fs = std::filesystem;
const fs::path kRoot = source_folder();

// Those beside the README, and all below docs/.
std::vector<Document> documents_of_the_project() {
  std::vector<Document> documents;
  const auto add = [&](const fs::directory_entry& entry) {
    if (!entry.is_regular_file() || entry.path().extension() != ".md") return;
    const Result<std::string> text = read_file(entry.path());
    ASSERT_THAT(text, IsOk());
    documents.push_back({fs::relative(entry.path(), kRoot).generic_string(), *text});
  };
  for (const auto& entry : fs::directory_iterator(kRoot)) add(entry);
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) add(entry);
  return documents;
}

bool exists_in_a_small_tree(const std::string& path) { return path == "core/rig.h" || path == "docs/adr"; }

std::vector<std::string> broken(const char* path, const char* text) {
  return broken_links({{path, text}}, exists_in_a_small_tree);
}

TEST(Documents, LinkOnlyToWhatIsThere) {
  const std::vector<Document> documents = documents_of_the_project();
  EXPECT_GT(documents.size(), 50u);
  EXPECT_THAT(broken_links(documents, [](const std::string& path) { return fs::exists(kRoot / path); }),
              IsEmpty());
}

TEST(Fuzzers, StandInTheirList) {
  const Result<std::string> list = read_file(kRoot / "tests/fuzz/README.md");
  ASSERT_TRUE(list);
  int fuzzers = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(kRoot / "tests/fuzz")) {
    const std::string name = file.path().stem().string();
    if (!name.ends_with("_fuzz") || file.path().extension() != ".cpp") continue;
    EXPECT_THAT(*list, HasSubstr("`" + name.substr(0, name.size() - 5) + "`"));
    ++fuzzers;
  }
  EXPECT_GT(fuzzers, 40);
}

TEST(Decisions, HaveANumberEachAndStandInTheirIndex) {
  const Result<std::string> index = read_file(kRoot / "docs/adr/README.md");
  ASSERT_TRUE(index);
  std::map<std::string, std::string> names;  // by number
  for (const fs::directory_entry& file : fs::directory_iterator(kRoot / "docs/adr")) {
    const std::string name = file.path().filename().string();
    if (name == "README.md") continue;
    const auto [other, is_new] = names.emplace(name.substr(0, 4), name);
    EXPECT_TRUE(is_new) << name << " has the number of " << other->second;
    EXPECT_THAT(*index, HasSubstr("(" + name + ")"));
  }
  EXPECT_GT(names.size(), 100u);
}

TEST(DocumentLinks, AreFoundOutsideOfCode) {
  const std::vector<DocumentLink> links = links_of(
      "one [a](x.md) and ![b](../y.png#top)\n```\n[no](fence.md)\n```\n`[no](code.md)` [c](#here)\n"
      "[other](https://example.org/z.md)\n");
  ASSERT_EQ(links.size(), 3u);
  EXPECT_EQ(links[0].target, "x.md");
  EXPECT_EQ(links[1].target, "../y.png");
  EXPECT_EQ(links[1].heading, "top");
  EXPECT_EQ(links[2].target, "");
  EXPECT_EQ(links[2].heading, "here");
  EXPECT_EQ(links[2].line, 5);
}

TEST(DocumentLinks, AreFoundWithCodeAsTheirText) {
  const std::vector<DocumentLink> links = links_of("[`rig.h`](../core/rig.h)\n");
  ASSERT_EQ(links.size(), 1u);
  EXPECT_EQ(links[0].target, "../core/rig.h");
}

TEST(DocumentLinks, AreFollowedFromTheirOwnFolder) {
  EXPECT_THAT(broken("docs/takes.md", "[a](../core/rig.h) [b](adr)\n"), IsEmpty());
  EXPECT_THAT(broken("docs/takes.md", "\n[a](core/rig.h)\n"),
              ElementsAre(HasSubstr("docs/takes.md:2: links to core/rig.h, which is not there")));
}

TEST(DocumentLinks, NeedTheHeadingThatTheyName) {
  const std::vector<Document> two = {{"a.md", "[b](b.md#who-calls-whom) [c](b.md#nobody)\n"},
                                     {"b.md", "# B\n## Who calls whom?\n```\n# nobody\n```\n"}};
  EXPECT_THAT(broken_links(two, exists_in_a_small_tree), ElementsAre("a.md:1: b.md has no heading 'nobody'"));
}

}  // namespace
}  // namespace floatstage::architecture
