#include <csignal>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/farm/farm_take.h"
#include "tests/support/eventually.h"

// --plan local: what items and processes make is what the verb makes by itself, whatever is killed on the
// way.
namespace floatstage {
namespace {

using testing::AllOf;
using testing::HasSubstr;

namespace fs = std::filesystem;

const char* const kWays = " --plan local --workers 2 --chunk 2 -j 1";

class APlan : public testing::Test {
 protected:
  // A take, and what `words` make of a copy of it.
  std::map<std::string, std::string> by_itself(const std::string& words) {
    const fs::path copy = copy_of(take_, "alone");
    const Ended made = floatstage(text(words, " ", quoted(copy), " -j 1"));
    EXPECT_EQ(made.code, 0) << made.output;
    return derived_files(copy);
  }
  fs::path plan(const char* verb) const { return take_.string() + "." + verb + ".plan"; }

  TempFolder folder_;
  const fs::path take_ = recorded_take(folder_, "take", 3);
};

TEST_F(APlan, MakesTheBytesOfTheVerbItself) {
  const auto alone = by_itself("process");
  const Ended made = floatstage("process " + quoted(take_) + kWays);
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(derived_files(take_), alone);
  const nlohmann::json items = shown(plan("process")).at("items");
  EXPECT_EQ(items.size(), 5u * 2 + 1 + 2 + 1) << "two chunks of 5 cameras, gather, two of instants, finish";
  for (const nlohmann::json& item : items) EXPECT_EQ(item.at("state"), "done") << item;

  const Ended again = floatstage("process " + quoted(take_) + kWays);
  EXPECT_EQ(again.code, 0) << again.output;
  EXPECT_EQ(shown(plan("process")).at("items").size(), 1u) << "nothing is left to do but to say so";
  EXPECT_EQ(derived_files(take_), alone);
}

// Before black and without a plate no key tells anybody. Its items are told so, and say nothing.
TEST_F(APlan, SaysWhatWasFoundWhileItWasMade) {
  const char* const found = "keys do not hold";
  const fs::path black = folder_ / "black";
  ASSERT_EQ(floatstage("-q synthesize -o " + quoted(black) +
                       " --stage black --camera-count 5 --frame-count 1 --size 160x120")
                .code,
            0);
  fs::remove_all(black / "plates");
  const Ended alone = floatstage("process " + quoted(copy_of(black, "alone")));
  EXPECT_THAT(alone.output, HasSubstr(found));
  const Ended made = floatstage("process " + quoted(black) + kWays + " --json " + quoted(folder_ / "report"));
  EXPECT_EQ(made.code, alone.code) << made.output;
  EXPECT_THAT(made.output, HasSubstr(found));
  const nlohmann::json report = nlohmann::json::parse(*read_file(folder_ / "report"));
  EXPECT_THAT(report.at("remarks").dump(), HasSubstr(found));
  const fs::path lies = black.string() + ".process.plan";
  EXPECT_THAT(floatstage("plan show " + quoted(lies)).output, HasSubstr(found));
  EXPECT_THAT(shown(lies).at("remarks").dump(), HasSubstr(found));
}

TEST_F(APlan, OfMattesIsOneToo) {
  const auto alone = by_itself("matte --matte chroma --frames 0:3:2");
  const Ended made = floatstage("matte " + quoted(take_) + " --matte chroma --frames 0:3:2" + kWays);
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(derived_files(take_), alone);
}

TEST_F(APlan, OfAFilmMakesItsBytes) {
  ASSERT_EQ(floatstage("process " + quoted(take_)).code, 0);
  const std::string render = "render " + quoted(take_) +
                             " --orbit --size 64x48 --fps 40 --seconds 4 --method linear --renderer cpu -o ";
  const Ended alone = floatstage(render + quoted(folder_ / "alone.mp4"));
  ASSERT_EQ(alone.code, 0) << alone.output;
  const fs::path film = folder_ / "film.mp4";
  const Ended made = floatstage(render + quoted(film) + " --plan local --workers 2 --chunk 50");
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(*read_file(film), *read_file(folder_ / "alone.mp4"));
  EXPECT_EQ(shown(film.string() + ".render.plan").at("items").size(), 3u + 1) << "parts, and the film";
}

TEST_F(APlan, OfScoresGivesTheirNumbers) {
  ASSERT_EQ(floatstage("process " + quoted(take_)).code, 0);
  const std::string evaluate = "evaluate " + quoted(take_) +
                               " --frames 0:3 --methods nearest,linear --scale 1/2 --renderer cpu --csv ";
  ASSERT_EQ(
      floatstage(evaluate + quoted(folder_ / "alone.csv") + " --json " + quoted(folder_ / "alone")).code, 0);
  const Ended made = floatstage(evaluate + quoted(folder_ / "plan.csv") + " --json " +
                                quoted(folder_ / "plan") + " --plan local --workers 2 --chunk 2");
  ASSERT_EQ(made.code, 0) << made.output;
  for (const char* end : {"", ".csv"})
    EXPECT_EQ(*read_file(folder_ / text("plan", end)), *read_file(folder_ / text("alone", end)));
  const Ended walk = floatstage(evaluate + "w.csv --orbit --plan local");
  EXPECT_EQ(walk.code, 3) << walk.output;
}

TEST_F(APlan, GoesOnWhereItWasKilled) {
  const auto alone = by_itself("process");
  const pid_t child = fork();
  if (child == 0) {
    execl(FLOATSTAGE_PROGRAM, "floatstage", "process", take_.c_str(), "--plan", "local", "--chunk", "1", "-j",
          "1", static_cast<char*>(nullptr));
    _exit(127);
  }
  ASSERT_TRUE(eventually([&] { return fs::exists(plan("process") / "items/mattes-cam01-0.json"); }));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);

  const Ended other = floatstage("process " + quoted(take_) + " --matte luminance" + kWays);
  EXPECT_EQ(other.code, 5) << other.output;
  EXPECT_THAT(other.output, HasSubstr("unfinished plan of another command"));

  const Ended made = floatstage("process " + quoted(take_) + kWays);
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(derived_files(take_), alone);
}

TEST_F(APlan, WithoutRoomSaysSoAndGoesOnWhereThereIs) {
  const auto alone = by_itself("process");
  std::ofstream(folder_ / "no-folder") << "a file";
  const Ended full = floatstage("process " + quoted(take_) + kWays + " --scratch " +
                                quoted(folder_ / "no-folder/scratch") + " --retries 1");
  EXPECT_EQ(full.code, 8) << full.output;
  EXPECT_THAT(full.output, AllOf(HasSubstr("no-folder"), HasSubstr("the same command goes on")));
  const Ended made = floatstage("process " + quoted(take_) + kWays);
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(derived_files(take_), alone);
}

TEST_F(APlan, IsShownAsATableAndAGraphAndTellsWhatMoreWouldCost) {
  const Ended made = floatstage("process " + quoted(take_) + kWays);
  ASSERT_EQ(made.code, 0) << made.output;
  const Ended table = floatstage("plan show " + quoted(plan("process")));
  EXPECT_THAT(table.output, AllOf(HasSubstr("mattes-cam03-2"), HasSubstr("14 of 14 items done, 0 failed")));
  const Ended graph = floatstage("plan show --dot " + quoted(plan("process")));
  EXPECT_THAT(graph.output,
              AllOf(HasSubstr("digraph plan {"), HasSubstr("\"mattes-cam00-0\" -> \"before gather\"")));
  const std::string cost = "plan cost " + quoted(plan("process")) + " --minutes 10 --camera-count 60 --json ";
  nlohmann::json one, eight;
  ASSERT_EQ(floatstage(cost + quoted(folder_ / "1") + " --node-count 1").code, 0);
  ASSERT_EQ(floatstage(cost + quoted(folder_ / "8") + " --node-count 8").code, 0);
  std::ifstream(folder_ / "1") >> one;
  std::ifstream(folder_ / "8") >> eight;
  EXPECT_EQ(one.at("work_seconds"), eight.at("work_seconds"));
  const double alone =
      one.at("stages").at("gather").get<double>() + one.at("stages").at("finish").get<double>();
  EXPECT_NEAR(eight.at("wall_seconds").get<double>(),
              alone + (one.at("work_seconds").get<double>() - alone) / 8, 1e-6);
}

}  // namespace
}  // namespace floatstage
