#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

Ended floatstage(const std::string& arguments) { return run_command(FLOATSTAGE_PROGRAM " " + arguments); }

TEST(CommandLine, ExplainsItself) {
  const Ended help = floatstage("--help");
  EXPECT_EQ(help.code, 0);
  for (const char* verb : {"demo", "check", "synthesize", "import", "process", "render", "evaluate", "play"})
    EXPECT_THAT(help.output, HasSubstr(verb));
  EXPECT_EQ(floatstage("--version").code, 0);
  EXPECT_THAT(floatstage("render --help").output,
              AllOf(HasSubstr("--orbit"), HasSubstr("floating"), HasSubstr("linear")));
  EXPECT_THAT(floatstage("process --help").output,
              AllOf(HasSubstr("chroma"), HasSubstr("difference"), HasSubstr("luminance")));
}

TEST(CommandLine, EndsWithTheUsageCodeAfterATypo) {
  EXPECT_EQ(floatstage("").code, 2);
  const Ended typo = floatstage("rendr");
  EXPECT_EQ(typo.code, 2);
  EXPECT_THAT(typo.output, AllOf(HasSubstr("'rendr'"), HasSubstr("did you mean 'render'?")));
  const Ended option = floatstage("render --sise 3");
  EXPECT_EQ(option.code, 2);
  EXPECT_THAT(option.output, HasSubstr("did you mean '--size'?"));
  EXPECT_EQ(floatstage("process").code, 2) << "the take is missing";
}

TEST(CommandLine, MakesAStudiosKeysOnce) {
  const TempFolder folder;
  const std::string file = (folder / "studio.keys").string();
  EXPECT_EQ(floatstage("keys --out " + file).code, 0);
  const Result<std::string> keys = read_file(file);
  ASSERT_THAT(keys, IsOk());
  EXPECT_THAT(*keys, AllOf(HasSubstr("public = "), HasSubstr("secret = ")));
  const Ended again = floatstage("keys --out " + file);
  EXPECT_NE(again.code, 0);
  EXPECT_THAT(again.output, HasSubstr("never written over"));
  EXPECT_EQ(*read_file(file), *keys);
}

TEST(CommandLine, NamesTheMissingTakeAndEndsWithItsCode) {
  for (const char* verb : {"process", "evaluate", "render --orbit --out /tmp/never-written.mp4"}) {
    const Ended ended = floatstage(std::string(verb) + " /no/such/take");
    EXPECT_EQ(ended.code, 4) << verb;
    EXPECT_THAT(ended.output, HasSubstr("/no/such/take")) << verb;
  }
}

TEST(CommandLine, SaysWhatAStudioOfSeveralMachinesNeeds) {
  const Ended alone = floatstage("live recon tcp://127.0.0.1:5580");
  EXPECT_EQ(alone.code, 2);
  EXPECT_THAT(alone.output, HasSubstr("--nodes is required"));
  const Ended both = floatstage("live view tcp://127.0.0.1:5580 --source take");
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.output, HasSubstr("no option --source"));
  const Ended lost =
      floatstage("live view tcp://127.0.0.1:5580 --nodes tcp://127.0.0.1:5570 --rig nowhere.json --headless");
  EXPECT_EQ(lost.code, 4);
  EXPECT_THAT(lost.output, HasSubstr("nowhere.json"));
}

TEST(CommandLine, SaysWhatIsWrongWithAnOption) {
  const Ended size = floatstage("synthesize --out /tmp/never-made --size 640*480");
  EXPECT_EQ(size.code, 3);
  EXPECT_THAT(size.output, HasSubstr("640x480"));
  EXPECT_EQ(floatstage("render /no/such/take --out x.mp4").code, 3) << "neither --orbit nor --path";
  const Ended method = floatstage("render take --orbit -o x.mp4 --method floting");
  EXPECT_EQ(method.code, 3);
  EXPECT_THAT(method.output, HasSubstr("did you mean 'floating'?"));
}

TEST(CommandLine, SaysWhatIsWrongWithAFilterAScaleOrAProxyBeforeItOpensTheTake) {
  const std::pair<const char*, const char*> wrong[] = {{"--depth-range 3:2", "3:2"},
                                                       {"--depth-range 3", "1.5:4"},
                                                       {"--uncertainty nan", "uncertainty"},
                                                       {"--band-limit -1", "band limit"},
                                                       {"--motion-blur 1", "motion blur"},
                                                       {"--field-memory 1", "field memory"},
                                                       {"--scale 2", "1/2"},
                                                       {"--scale 1/0", "1/2"},
                                                       {"--proxy cube", "plane:Z"},
                                                       {"--inputs ,", "names nothing"},
                                                       {"--orbit --path p.json", "either --orbit or --path"}};
  for (const auto& [words, sentence] : wrong) {
    const Ended ended = floatstage(std::string("evaluate /no/such/take ") + words);
    EXPECT_EQ(ended.code, 3) << words << ": " << ended.output;
    EXPECT_THAT(ended.output, HasSubstr(sentence)) << words;
  }
}

TEST(CommandLine, LeavesAnUnwritableFolderAlone) {
  const Ended ended = floatstage("synthesize --out /proc/no/take --frame-count 1");
  EXPECT_EQ(ended.code, 8) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("/proc/no"));
}

TEST(CommandLine, NeverWritesOverATake) {
  TempFolder folder;
  const std::string out = (folder / "take").string(),
                    verb =
                        "synthesize --frame-count 1 --camera-count 2 --size 64x48 --samples 1 --out " + out;
  EXPECT_EQ(floatstage(verb).code, 0);
  const std::string before = *read_file(folder / "take/take.json");
  const Ended again = floatstage(verb);
  EXPECT_EQ(again.code, 5) << again.output;
  EXPECT_THAT(again.output, HasSubstr(out));
  EXPECT_EQ(*read_file(folder / "take/take.json"), before);
}

TEST(CommandLine, DemoRefusesAFolderThatHoldsSomebodysFiles) {
  TempFolder folder;
  folder.write("thesis.doc", "years of work");
  const Ended ended = floatstage("demo --out " + folder.path().string());
  EXPECT_EQ(ended.code, 5);
  EXPECT_THAT(folder.names(), testing::ElementsAre("thesis.doc"));
}

TEST(CommandLine, ReportsAHullWithTheKeysThatBenchesRead) {
  TempFolder folder;
  const std::string take = (folder / "take").string();
  ASSERT_EQ(
      floatstage("synthesize --frame-count 1 --camera-count 6 --size 160x120 --samples 4 -o " + take).code,
      0);
  ASSERT_EQ(floatstage("process --matte chroma " + take).code, 0);
  const std::string json_file = (folder / "H.json").string();
  for (const char* mesh : {"hull.ply", "hull.glb"}) {
    const Ended ended = floatstage(
        "hull " + take + " --threads 1 --repeat 3 --collapse-slivers --smooth 2 --triangles 900 --json " +
        json_file + " --out " + (folder / mesh).string());
    ASSERT_EQ(ended.code, 0) << ended.output;
    EXPECT_THAT(ended.output, HasSubstr("cleanup: "));
  }
  const nlohmann::json report = nlohmann::json::parse(*read_file(json_file));
  EXPECT_GT(report.at("ms").at("p50").get<double>(), 0);
  EXPECT_GE(report.at("ms").at("p95"), report.at("ms").at("p50"));
  EXPECT_EQ(report.at("triangles"), 900);
  EXPECT_GT(report.at("vertices").get<int>(), 400);
  EXPECT_GT(report.at("faces").get<int>(), 100);
  EXPECT_GT(report.at("volume").get<double>(), 0.01);
  EXPECT_EQ(report.at("watertight"), true);
  EXPECT_EQ(report.at("manifold"), true);
  EXPECT_EQ(report.at("iou").size(), 6u);
  EXPECT_GT(report.at("mean_iou").get<double>(), 0.9);
  EXPECT_EQ(report.at("escalations"), 0);
  const nlohmann::json& cleanup = report.at("cleanup");
  EXPECT_GT(cleanup.at("triangles").at(0), cleanup.at("triangles").at(1));
  for (const char* list : {"vertex_move", "silhouette_shift", "iou_loss"})
    EXPECT_EQ(cleanup.at(list).size(), 6u) << list;
  EXPECT_EQ(read_file(folder / "hull.glb")->substr(0, 4), "glTF");
  EXPECT_EQ(read_file(folder / "hull.ply")->substr(0, 3), "ply");

  const Ended other = floatstage("hull " + take + " --json " + (folder / "other.json").string() + " --out " +
                                 (folder / "hull.stl").string());
  EXPECT_EQ(other.code, 3);
  EXPECT_THAT(other.output, HasSubstr("hull.stl: a mesh is a .ply or a .glb file"));
  EXPECT_THAT(folder.names(), testing::UnorderedElementsAre("H.json", "hull.glb", "hull.ply", "take"))
      << "nothing was computed, nothing written";
}

}  // namespace
}  // namespace floatstage::apps
