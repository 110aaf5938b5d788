// Reads the project's own sources and holds them to docs/architecture.md.

#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/architecture_rules.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"

namespace floatstage::architecture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::filesystem::path kRoot = source_folder();

std::string read(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  EXPECT_THAT(bytes, IsOk());
  return bytes ? *bytes : "";
}

bool is_source(const std::filesystem::path& file) {
  const std::set<std::string> kinds = {".h", ".cpp", ".in", ".glsl", ".vert", ".frag", ".comp", ".cmake"};
  return kinds.contains(file.extension().string()) || file.filename() == "CMakeLists.txt";
}

// What lies in the folders of the product and its tests; builds, takes and hidden folders lie elsewhere.
struct Project {
  std::vector<SourceFile> files;
  std::vector<std::string> folders;

  Project() {
    std::vector<std::string> tops(stages().begin(), stages().end());
    for (const char* top : {"core", "pipeline", "studio", "apps", "tests", "docs", "config", "packaging"})
      tops.push_back(top);
    for (const auto& entry : std::filesystem::directory_iterator(kRoot))
      if (entry.is_directory()) folders.push_back(entry.path().filename().string());
    for (const std::string& top : tops) {
      if (!std::filesystem::is_directory(kRoot / top)) continue;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(kRoot / top)) {
        const std::string path = std::filesystem::relative(entry.path(), kRoot).generic_string();
        if (entry.is_directory()) folders.push_back(path);
        if (entry.is_regular_file() && is_source(entry.path())) files.push_back({path, read(entry.path())});
      }
    }
  }
};

std::set<std::string> headers_of_the_table() { return public_headers(read(kRoot / "docs/architecture.md")); }

TEST(Architecture, IsReadFromTheWholeProject) {
  const Project project;
  EXPECT_GT(project.files.size(), 50u);
  const std::set<std::string> headers = headers_of_the_table();
  for (const char* header : {"core/rig.h", "core/synthetic/synthetic_studio.h", "capture/take.h",
                             "matting/keyers/keyer.h", "recon/visual_hull.h", "render/renderer.h"})
    EXPECT_TRUE(headers.contains(header)) << header;
}

TEST(Architecture, LetsOnlyTheFloorsAboveComposeTheStages) {
  EXPECT_THAT(breaches_of_layering(Project().files, headers_of_the_table()), IsEmpty());
}

TEST(Architecture, GoesStrictlyDownwardsInsideEachFloor) {
  EXPECT_THAT(breaches_of_ranks(Project().files), IsEmpty());
}

TEST(Architecture, LeavesCommandLineAndWindowsToApps) {
  EXPECT_THAT(breaches_of_user_interface(Project().files), IsEmpty());
}

TEST(Architecture, HasNoFolderCycles) { EXPECT_THAT(breaches_of_folder_cycles(Project().files), IsEmpty()); }

TEST(Architecture, KeepsOtherLibrariesOutOfPublicHeaders) {
  EXPECT_THAT(breaches_of_public_headers(Project().files, headers_of_the_table()), IsEmpty());
}

TEST(Architecture, HasNoFolderForLeftovers) {
  EXPECT_THAT(breaches_of_folder_names(Project().folders), IsEmpty());
}

TEST(Architecture, KeepsFilesShort) { EXPECT_THAT(breaches_of_length(Project().files), IsEmpty()); }

// From here on: the rules find what they are for.

std::vector<std::string> layering(const char* path, const char* text) {
  return breaches_of_layering({{path, text}}, {"matting/keyers/keyer.h"});
}

TEST(Architecture, KeepsLinesNarrow) { EXPECT_THAT(breaches_of_width(Project().files), IsEmpty()); }

TEST(Architecture, SetsOpenCvsThreadsBeforeMain) {
  EXPECT_THAT(breaches_of_opencv_threads(Project().files), IsEmpty());
}

TEST(IncludesOf, FindsBothKindsAndSkipsComments) {
  const std::vector<Include> found = includes_of(
      "// #include \"a.h\"\n/* x\n#include <b>\n*/\n#include \"c/d.h\"  // why\n  #  include <Eigen/Core>\n");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].target, "c/d.h");
  EXPECT_FALSE(found[0].angled);
  EXPECT_EQ(found[0].line, 5);
  EXPECT_EQ(found[1].target, "Eigen/Core");
  EXPECT_TRUE(found[1].angled);
  EXPECT_EQ(found[1].line, 6);
}

TEST(PublicHeaders, AreTheThirdColumnOfTheTable) {
  EXPECT_THAT(public_headers("| folder | a | b |\n| --- | --- | --- |\n| `core/` | the words | `time frame` "
                             "| x |\n| `core/synthetic/` | y | `studio` |\n"),
              ElementsAre("core/frame.h", "core/synthetic/studio.h", "core/time.h"));
}

TEST(Layering, FindsAStageThatIncludesAnother) {
  EXPECT_THAT(layering("recon/hull.cpp", "#include \"core/rig.h\"\n#include \"matting/keyers/keyer.h\"\n"),
              ElementsAre(HasSubstr("recon/hull.cpp:2: includes matting/keyers/keyer.h: a stage must not")));
  EXPECT_THAT(layering("recon/hull.cpp", "#include <matting/keyers/keyer.h>\n"), testing::SizeIs(1))
      << "angle brackets hide nothing";
}

TEST(Layering, FindsCoreThatKnowsAStage) {
  EXPECT_THAT(layering("core/rig.h", "#include \"matting/keyers/keyer.h\"\n"),
              ElementsAre(HasSubstr("core must not")));
  EXPECT_THAT(layering("core/synthetic/studio.cpp", "#include \"capture/take.h\"\n"),
              ElementsAre(HasSubstr("core must not")));
}

TEST(Layering, KeepsTheSyntheticStudioFromStages) {
  const char* studio = "#include \"core/synthetic/synthetic_studio.h\"\n";
  EXPECT_THAT(layering("matting/keyers/keyer.cpp", studio), ElementsAre(HasSubstr("core/synthetic is for")));
  EXPECT_THAT(layering("core/rig.cpp", studio), ElementsAre(HasSubstr("core/synthetic is for")));
  EXPECT_THAT(layering("capture/synthetic_source.cpp", studio), IsEmpty());
  EXPECT_THAT(layering("pipeline/synthesize.cpp", studio), IsEmpty());
}

TEST(Layering, KeepsAppsToPublicHeaders) {
  EXPECT_THAT(layering("apps/main.cpp",
                       "#include \"matting/keyers/keyer.h\"\n#include \"pipeline/film.h\"\n#include "
                       "\"core/json_fields.h\"\n"),
              IsEmpty());
  EXPECT_THAT(layering("apps/main.cpp", "#include \"matting/keyers/backing.h\"\n"),
              ElementsAre(HasSubstr("does not name as public")));
}

TEST(Layering, KeepsAppsAndTestsOutOfTheStages) {
  EXPECT_THAT(layering("render/ulr.cpp", "#include \"apps/terminal/text_options.h\"\n"),
              ElementsAre(HasSubstr("apps is the top floor")));
  EXPECT_THAT(layering("apps/main.cpp", "#include \"tests/support/matchers.h\"\n"),
              ElementsAre(HasSubstr("must not include tests")));
  EXPECT_THAT(layering("tests/recon/hull_test.cpp",
                       "#include \"recon/octree.h\"\n#include \"matting/keyers/backing.h\"\n"),
              IsEmpty());
}

TEST(Layering, KeepsPipelineAndStudioApart) {
  EXPECT_THAT(layering("pipeline/film.cpp", "#include \"studio/live/live_chain.h\"\n"),
              ElementsAre(HasSubstr("beside the other floor")));
  EXPECT_THAT(layering("studio/live/live_chain.cpp", "#include \"pipeline/film.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(layering("recon/visual_hull.cpp", "#include \"pipeline/film.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(layering("pipeline/film.cpp", "#include \"apps/terminal/interrupt.h\"\n"), testing::SizeIs(1));
  EXPECT_THAT(layering("apps/render_verb.cpp", "#include \"pipeline/film.h\"\n"), IsEmpty());
}

// A tree in which the network knows what runs on it.
TEST(Ranks, FindANetworkThatKnowsTheLiveChain) {
  const std::vector<SourceFile> tree = {
      {"studio/network/publisher.h", "#include \"studio/messages/message.h\"\n"},
      {"studio/network/publisher.cpp",
       "#include \"studio/network/publisher.h\"\n#include \"studio/live/live_chain.h\"\n"},
      {"studio/live/live_chain.h", "#include \"studio/node/camera_rack.h\"\n"}};
  EXPECT_THAT(breaches_of_ranks(tree),
              ElementsAre(HasSubstr("studio/network/publisher.cpp:2: includes studio/live/live_chain.h: "
                                    "studio/live is not below studio/network")));
}

TEST(Ranks, AskForTheRankOfANewFolder) {
  EXPECT_THAT(breaches_of_ranks({{"pipeline/stray/a.cpp", "#include \"pipeline/film.h\"\n"}}),
              ElementsAre(HasSubstr("pipeline/stray has no rank")));
}

// A tree in which a job speaks the command line's words.
TEST(UserInterface, StaysOutOfPipeline) {
  const std::vector<SourceFile> tree = {
      {"pipeline/film.h", "#include \"core/result.h\"\n"},
      {"pipeline/film.cpp", "#include \"pipeline/film.h\"\n\n#include <CLI/CLI.hpp>\n"},
      {"studio/node/page.cpp", "#include <imgui.h>\n#include <GLFW/glfw3.h>\n"},
      {"apps/film_verb.cpp", "#include <CLI/CLI.hpp>\n"}};
  EXPECT_THAT(breaches_of_user_interface(tree),
              ElementsAre(HasSubstr("pipeline/film.cpp:3: includes CLI/CLI.hpp"),
                          HasSubstr("studio/node/page.cpp:1"), HasSubstr("studio/node/page.cpp:2")));
}

// A tree of rooms that cannot be read one after the other.
TEST(FolderCycles, AreFoundAlsoByWayOfAThirdFolder) {
  std::vector<SourceFile> tree = {{"recon/mesh/decimate.h", "#include \"recon/exact/half_edges.h\"\n"},
                                  {"recon/exact/half_edges.h", "#include \"recon/octree/cell.h\"\n"},
                                  {"recon/octree/cell.h", ""},
                                  {"recon/octree/cell.cpp", ""}};
  EXPECT_THAT(breaches_of_folder_cycles(tree), IsEmpty());
  tree[3].text = "#include \"recon/mesh/decimate.h\"\n";
  EXPECT_THAT(breaches_of_folder_cycles(tree),
              ElementsAre(testing::AllOf(HasSubstr("recon/mesh/decimate.h:1"), HasSubstr("half_edges.h:1"),
                                         HasSubstr("recon/octree/cell.cpp:1"))));
}

TEST(FolderCycles, AllowAStageToComposeItsRooms) {
  const std::vector<SourceFile> stage = {
      {"recon/visual_hull.h", ""},
      {"recon/visual_hull.cpp", "#include \"recon/exact/exact_method.h\"\n"},
      {"recon/exact/exact_method.h", "#include \"recon/visual_hull.h\"\n"}};
  EXPECT_THAT(breaches_of_folder_cycles(stage), IsEmpty());
  const std::vector<SourceFile> floor = {{"pipeline/film.h", ""},
                                         {"pipeline/film.cpp", "#include \"pipeline/evaluate/scores.h\"\n"},
                                         {"pipeline/evaluate/scores.h", "#include \"pipeline/film.h\"\n"}};
  EXPECT_THAT(breaches_of_folder_cycles(floor), testing::SizeIs(1));
}

TEST(PublicHeaderRule, FindsOtherLibrariesAlsoBehindAPrivateHeader) {
  const std::vector<SourceFile> files = {
      {"core/rig.h", "#include <vector>\n#include <Eigen/Core>\n#include \"core/inner.h\"\n"},
      {"core/inner.h", "#include <opencv2/core.hpp>\n#include <unistd.h>\n#include \"json.hpp\"\n"},
      {"core/free.h", "#include <png.h>\n"}};
  EXPECT_THAT(breaches_of_public_headers(files, {"core/rig.h"}),
              ElementsAre(HasSubstr("core/inner.h:1: includes opencv2/core.hpp"),
                          HasSubstr("core/inner.h:2: includes unistd.h"),
                          HasSubstr("core/inner.h:3: includes json.hpp")));
}

TEST(PublicHeaderRule, FindsAHeaderThatIsOnlyInTheTable) {
  EXPECT_THAT(breaches_of_public_headers({}, {"core/gone.h"}), ElementsAre(HasSubstr("core/gone.h")));
}

TEST(FolderNames, FindsDrawersForLeftovers) {
  EXPECT_THAT(
      breaches_of_folder_names({"core", "common", "render/util", "docs/adr", "third_party", "apps/include"}),
      testing::SizeIs(4));
  EXPECT_THAT(breaches_of_folder_names({"core/utility_room"}), IsEmpty());
}

TEST(Length, FindsAFileOfMoreThanSixHundredLines) {
  EXPECT_THAT(breaches_of_length({{"a.cpp", std::string(600, '\n')}}), IsEmpty());
  EXPECT_THAT(breaches_of_length({{"a.cpp", std::string(601, '\n')}}),
              ElementsAre(HasSubstr("a.cpp: 601 lines")));
}

TEST(Width, CountsCharactersAndLeavesRawStringsAlone) {
  const std::string wide(111, 'x');
  EXPECT_THAT(breaches_of_width({{"a.cpp", std::string(110, 'x') + "\n"}, {"a.txt", wide}}), IsEmpty());
  EXPECT_THAT(breaches_of_width({{"a.cpp", "int a;\n" + wide + "\n"}}),
              ElementsAre("a.cpp:2: 111 columns; at most 110"));
  std::string dots;
  for (int i = 0; i < 110; ++i) dots += "…";
  EXPECT_THAT(breaches_of_width({{"a.cpp", dots}}), IsEmpty());
  const std::string open = "R\"js(", close = ")js\";";  // in two pieces: this file is looked at as well
  EXPECT_THAT(breaches_of_width({{"a.cpp", open + wide + "\n" + wide + close + "\n" + wide}}),
              ElementsAre(HasSubstr("a.cpp:3")));
}

TEST(OpenCvThreads, MayBeSetByAConstantAlone) {
  EXPECT_THAT(
      breaches_of_opencv_threads({{"render/a.cpp", "inline const bool k = (cv::setNumThreads(1), true);\n"},
                                  {"tests/bench/b.cpp", "  cv::setNumThreads(2);\n"}}),
      IsEmpty());
  EXPECT_THAT(breaches_of_opencv_threads({{"render/a.cpp", "void f() {\n  cv::setNumThreads(1);\n}\n"}}),
              ElementsAre(HasSubstr("render/a.cpp:2")));
}

}  // namespace
}  // namespace floatstage::architecture
