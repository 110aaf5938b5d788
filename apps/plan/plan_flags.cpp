#include "apps/plan/plan_flags.h"

#include <algorithm>
#include <array>

#include "apps/terminal/flags.h"

namespace floatstage::apps {
namespace {

constexpr int kMostWorkers = 1024, kMostFrames = 1000000, kMostRetries = 100;

// Each has one value.
constexpr std::array<const char*, 7> kNames = {"--plan",  "--plan-folder", "--scratch", "--workers",
                                               "--chunk", "--retries",     "--sbatch"};

}  // namespace

void add_plan_flags(CLI::App& verb, PlanFlags& flags) {
  verb.add_option("--plan", flags.backend,
                  "Divide the work into items that go on where they were stopped, and have them done by "
                  "processes of this machine or by a Slurm cluster (docs/farm.md)")
      ->check(one_of({"local", "slurm"}))
      ->group(kGroupPlan);
  verb.add_option("--plan-folder", flags.folder,
                  "Where the plan lies; on a file system that all machines have (default: beside the take)")
      ->type_name("FOLDER")
      ->group(kGroupPlan);
  verb.add_option("--scratch", flags.scratch,
                  "Where items work, on each machine (default: in the plan's folder)")
      ->type_name("FOLDER")
      ->group(kGroupPlan);
  verb.add_option("--workers", flags.workers,
                  "Items at once on this machine; 0: one, or of -j threads as many as it has cores for")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(0, kMostWorkers).description(""))
      ->group(kGroupPlan);
  verb.add_option("--chunk", flags.chunk, "Frames of an item, at most")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(1, kMostFrames).description(""))
      ->group(kGroupPlan);
  verb.add_option("--retries", flags.retries, "How often an item is tried again that a machine failed at")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Range(0, kMostRetries).description(""))
      ->group(kGroupPlan);
  verb.add_option("--sbatch", flags.sbatch,
                  "More options for Slurm's sbatch: \"--partition=gpu --cpus-per-task=8\"")
      ->type_name("WORDS")
      ->group(kGroupPlan);
}

std::vector<std::string> without_plan_flags(const std::vector<std::string>& words) {
  std::vector<std::string> left;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string name = words[i].substr(0, words[i].find('='));
    if (std::find(kNames.begin(), kNames.end(), name) == kNames.end())
      left.push_back(words[i]);
    else if (name == words[i])
      ++i;  // and its value
  }
  return left;
}

}  // namespace floatstage::apps
