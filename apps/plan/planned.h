#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/plan/plan_flags.h"
#include "apps/terminal/verb.h"
#include "core/result.h"
#include "pipeline/plan/plan.h"

namespace floatstage::apps {

/// How an item ended that was carried out.
struct ItemEnd {
  std::uint64_t bytes = 0;       ///< that it wrote
  std::optional<Error> verdict;  ///< of the last item: what the verb ends with, though its work is done
};

/// A verb whose work can be divided: what its options ask for, as items, and how one is done. The same in the
/// process that makes the plan and in those that carry it out, which read the plan's command line again.
struct Planned {
  std::filesystem::path folder;  ///< of the plan, where none is said
  int threads = 0;               ///< of an item; 0: one per core
  /// What is left to do. No folder, command or program yet.
  std::function<Result<pipeline::Plan>(int chunk)> make;
  /// Plan::made_from as it is now.
  std::function<Result<std::string>()> made_from;
  /// In any process, any number of times. Errors are the machine's or the job's, and nothing is half made.
  std::function<Result<ItemEnd>(const pipeline::Plan&, const pipeline::PlanItem&)> run;
};

/// Where the plan of a verb lies that works on `of`: take.process.plan.
std::filesystem::path plan_beside(const std::filesystem::path& of, const char* verb);

/// The end of a plan's last item, which has the verb report: its verdict. Io and Cancelled are the item's.
Result<ItemEnd> end_of(const Result<void>& verb);

/// What Chosen::run is of a verb with add_plan_flags(): who has the function's target may ask for its items.
struct PlannedRun {
  PlanFlags flags;
  std::function<Result<void>()> alone;  ///< how it runs without --plan
  std::function<Planned()> planned;
  std::vector<std::string> words = {};  ///< behind the program's name: main() says them

  Result<void> operator()() const;
};

/// The flags of --plan, and what the verb then does: of options that hold a PlanFlags `plan`, by itself
/// (`run`) or as items (`planned`).
template <class Options>
void add_planned_run(CLI::App& verb, Chosen& chosen, const std::shared_ptr<Options>& options,
                     Result<void> (*run)(const Options&), Planned (*planned)(const Options&)) {
  add_plan_flags(verb, options->plan);
  verb.callback([=, &chosen] {
    chosen.run = PlannedRun{options->plan, [=] { return run(*options); }, [=] { return planned(*options); }};
  });
}

/// Makes the plan, or goes on with the one that lies there, and ends as the verb would. `words`: the command
/// line. AlreadyExists when the folder has an unfinished plan of something else.
Result<void> run_planned(const std::vector<std::string>& words, const Planned& planned,
                         const PlanFlags& flags);

/// Whether it may go well another time, or on another machine.
bool may_go_well_again(ErrorCode code);

/// Carries a plan's items out as processes of this machine, `workers` at once. The first error that ends it.
Result<void> run_on_this_machine(const pipeline::Plan& plan, int workers, int retries);

/// Carries a plan's items out as job arrays of a Slurm cluster, and follows them. Unsupported without Slurm.
Result<void> run_on_slurm(const pipeline::Plan& plan, const PlanFlags& flags);

/// What `plan run` is called with, and where it is: this program.
std::filesystem::path this_program();

/// For pools: the error to end with when these items are not done, or Cancelled.
Unexpected not_done(const pipeline::Plan& plan, const pipeline::PlanStatus& status);

}  // namespace floatstage::apps
