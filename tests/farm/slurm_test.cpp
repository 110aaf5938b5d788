#include <filesystem>
#include <future>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/farm/farm_take.h"
#include "tests/farm/slurm_lab.h"
#include "tests/support/eventually.h"
#include "tests/support/real_data.h"

// --plan slurm: a real cluster of two machines makes the bytes of this one, whatever happens to it.
namespace floatstage {
namespace {

using testing::HasSubstr;
using testing::IsSupersetOf;

namespace fs = std::filesystem;

class ASlurmCluster : public testing::Test {
 protected:
  void SetUp() override {
    const bool possible =
        ::geteuid() == 0 && run_command("PATH=$PATH:/usr/sbin; which slurmctld slurmd munged").code == 0;
    if (possible) return;
    if (on_ci()) FAIL() << "a cluster takes root's rights, slurm-wlm and munge";
    GTEST_SKIP() << "a cluster takes root's rights, slurm-wlm and munge";
  }

  // A recorded take, and what this machine makes of it.
  void record(int frames) {
    take_ = recorded_take(folder_, "take", frames);
    const fs::path copy = copy_of(take_, "alone");
    const Ended made = floatstage(text("process ", quoted(copy), " --plan local --chunk 2 -j 1"));
    ASSERT_EQ(made.code, 0) << made.output;
    alone_ = derived_files(copy);
  }
  std::string process(const std::string& more = "") const {
    return text(FLOATSTAGE_PROGRAM " process ", quoted(take_), " --plan slurm --chunk 2 -j 1 ", more);
  }
  fs::path plan() const { return take_.string() + ".process.plan"; }
  std::set<std::string> nodes() const {
    std::set<std::string> all;
    const nlohmann::json plan_now = shown(plan());
    for (const nlohmann::json& item : plan_now.at("items")) all.insert(item.at("node"));
    return all;
  }

  TempFolder folder_;
  fs::path take_;
  std::map<std::string, std::string> alone_;
};

TEST_F(ASlurmCluster, MakesTheBytesOfThisMachine) {
  record(3);
  const SlurmLab lab;
  const Ended made = lab.run(process());
  ASSERT_EQ(made.code, 0) << made.output << lab.logs();
  EXPECT_EQ(derived_files(take_), alone_);
  EXPECT_THAT(nodes(), testing::ElementsAre("node1", "node2"));
}

TEST_F(ASlurmCluster, GoesOnWhenAMachineDies) {
  record(4);
  SlurmLab lab;
  std::future<Ended> run = std::async(std::launch::async, [&] { return lab.run(process()); });
  ASSERT_TRUE(eventually([&] {
    return lab.run("squeue --noheader --states=RUNNING --nodelist=node2 --format=%i").output.size() > 1;
  })) << lab.logs();
  lab.kill_node("node2");
  const Ended made = run.get();
  ASSERT_EQ(made.code, 0) << made.output << lab.logs();
  EXPECT_EQ(derived_files(take_), alone_);
}

TEST_F(ASlurmCluster, LeavesAMachineWhoseDiskIsFull) {
  record(3);
  const SlurmLab lab({{"node2", 8 << 10}});
  const Ended made = lab.run(process("--scratch " + quoted(lab.scratch())));
  ASSERT_EQ(made.code, 0) << made.output << lab.logs();
  EXPECT_THAT(made.output, HasSubstr("no more items for node2"));
  EXPECT_EQ(derived_files(take_), alone_);
  EXPECT_THAT(nodes(), testing::ElementsAre("node1")) << "of all that were done in the end";
}

TEST_F(ASlurmCluster, GoesOnAfterAnArrayWasCancelled) {
  record(3);
  const SlurmLab lab;
  std::future<Ended> run = std::async(std::launch::async, [&] { return lab.run(process()); });
  ASSERT_TRUE(eventually([&] { return fs::exists(plan() / "items/mattes-cam00-0.json"); })) << lab.logs();
  lab.run("scancel --name=floatstage-mattes");
  const Ended stopped = run.get();
  EXPECT_EQ(stopped.code, 130) << stopped.output << lab.logs();
  EXPECT_THAT(stopped.output, HasSubstr("the same command goes on"));
  const int before = shown(plan()).at("done");
  EXPECT_GT(before, 0);
  EXPECT_LT(before, 14);

  // On the other pool this time: it is the same plan.
  const Ended made = floatstage(text("process ", quoted(take_), " --plan local --chunk 2 -j 1"));
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_EQ(derived_files(take_), alone_);
}

}  // namespace
}  // namespace floatstage
