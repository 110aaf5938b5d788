#include "apps/plan/plan_verb.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/plan/plan_words.h"
#include "apps/plan/planned.h"
#include "apps/terminal/flags.h"
#include "capture/sha256.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/plan/plan.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using pipeline::ItemResult;
using pipeline::Plan;
using pipeline::PlanItem;
using pipeline::PlanStatus;

struct RunOptions {
  fs::path folder, json_file;
  std::string item;
};

struct ShowOptions {
  fs::path folder, json_file;
  bool dot = false;
};

struct CostOptions {
  fs::path folder, json_file;
  FarmSize farm;
};

CLI::Option* add_plan_folder(CLI::App& verb, fs::path& folder) {
  return verb.add_option("plan", folder, "A plan's folder")->required()->type_name("PLAN");
}

std::string this_node() {
  if (const char* node = std::getenv("SLURMD_NODENAME")) return node;
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  return host;
}

// The verb of the plan's command line, as it was said.
Result<Planned> planned_verb(const Plan& plan, const CommandLineReader& read) {
  std::error_code error;
  fs::current_path(plan.said_in, error);
  if (error)
    return fail(ErrorCode::Io, text("cannot go to ", plan.said_in.string(), ": ", error.message(),
                                    "; a plan's folders are to be on every machine"));
  const Result<Chosen> chosen = read(plan.command);
  if (!chosen) return fail(chosen.error().code, text(plan.file().string(), ": ", chosen.error().message));
  const PlannedRun* verb = chosen->run.target<PlannedRun>();
  if (!verb) return fail(ErrorCode::BadData, text(plan.file().string(), " has a verb without plans"));
  return verb->planned();
}

// What has to be so before an item is begun.
Result<void> check_ready(const Plan& plan, const PlanItem& item) {
  const Result<capture::FileHash> program =
      capture::sha256_of_file("/proc/self/exe", [](std::uint64_t) { return true; });
  if (!program) return forward(program);
  if (program->sha256 != plan.program)
    return fail(ErrorCode::Unsupported,
                text(this_node(), " has another version of Floatstage than the plan in ",
                     plan.folder.string(), "; install one version on all machines"));
  for (const PlanItem& before : plan.items) {
    if (before.stage == item.stage) return {};
    const Result<std::optional<ItemResult>> result = load_result(plan, before.id);
    if (!result) return forward(result);
    if (!*result || !(*result)->done)
      return fail(ErrorCode::NotFound,
                  text("item ", item.id, " needs ", before.id, ", which is not done yet"));
  }
  return {};
}

Result<void> run_item(const RunOptions& given, const CommandLineReader& read) {
  const Result<Plan> plan = pipeline::load_plan(given.folder);
  if (!plan) return forward(plan);
  const PlanItem* item = plan->find(given.item);
  if (!item)
    return fail(ErrorCode::InvalidArgument, text(plan->file().string(), " has no item '", given.item, "'"));
  Result<std::optional<ItemResult>> before = load_result(*plan, item->id);
  if (!before) return forward(before);
  if (*before && (*before)->done) return {};
  ItemResult result;
  result.attempts = (*before ? (*before)->attempts : 0) + 1;
  result.node = this_node();
  if (Result<void> ok = check_ready(*plan, *item); !ok) {
    if (ok.error().code == ErrorCode::NotFound) return ok;  // it may come: nothing was tried
    result.error = ok.error();
    if (Result<void> said = save_result(*plan, item->id, result); !said) return said;
    return ok;
  }
  const Result<Planned> verb = planned_verb(*plan, read);
  if (!verb) return forward(verb);
  const auto begin = std::chrono::steady_clock::now();
  const Result<ItemEnd> end = verb->run(*plan, *item);
  result.done = end.has_value();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (end) result.bytes = end->bytes;
  if (end && end->verdict) result.error = end->verdict;
  if (!end) result.error = end.error();
  if (Result<void> ok = save_result(*plan, item->id, result); !ok) return ok;
  if (!end) return forward(end);
  return given.json_file.empty()
             ? Result<void>()
             : pipeline::save_json(
                   {{"item", item->id}, {"seconds", result.seconds}, {"bytes_written", result.bytes}},
                   given.json_file);
}

Result<void> show(const ShowOptions& given) {
  const Result<Plan> plan = pipeline::load_plan(given.folder);
  if (!plan) return forward(plan);
  const Result<PlanStatus> status = status_of(*plan);
  if (!status) return forward(status);
  std::fputs((given.dot ? dot_of(*plan, *status) : table_of(*plan, *status)).c_str(), stdout);
  return given.json_file.empty() ? Result<void>()
                                 : pipeline::save_json(json_of(*plan, *status), given.json_file);
}

Result<void> cost(const CostOptions& given) {
  const Result<Plan> plan = pipeline::load_plan(given.folder);
  if (!plan) return forward(plan);
  const Result<PlanStatus> status = status_of(*plan);
  if (!status) return forward(status);
  const Result<FarmCost> cost = cost_of(*plan, *status, given.farm);
  if (!cost) return forward(cost);
  std::fputs(sentence(*cost, given.farm).c_str(), stdout);
  return given.json_file.empty() ? Result<void>() : pipeline::save_json(json_of(*cost), given.json_file);
}

void add_plan_run(CLI::App& parent, Chosen& chosen, const CommandLineReader& read) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* verb = add_verb(parent, chosen, "run",
                            "Carries one item of a plan out, if it is not done: what pools and clusters call",
                            {"floatstage plan run take.process.plan --item mattes-cam01-0",
                             "floatstage plan run take.process.plan --item finish"});
  add_plan_folder(*verb, options->folder);
  verb->add_option("--item", options->item, "Its name, as `plan show` has it")->required()->type_name("NAME");
  add_json(*verb, options->json_file);
  verb->callback([=, &chosen] { chosen.run = [=] { return run_item(*options, read); }; });
}

void add_plan_show(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* verb =
      add_verb(parent, chosen, "show", "Items of a plan, how far they are, and when all are done",
               {"floatstage plan show take.process.plan",
                "floatstage plan show take.process.plan --dot --json plan.json"});
  add_plan_folder(*verb, options->folder);
  verb->add_flag("--dot", options->dot, "As a graph in the language of Graphviz, instead of a table");
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return show(*options); }; });
}

void add_plan_cost(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<CostOptions>();
  CLI::App* verb = add_verb(
      parent, chosen, "cost", "What a larger take would cost, by the seconds that the items of a plan took",
      {"floatstage plan cost take.process.plan --camera-count 60 --minutes 10 --node-count 8",
       "floatstage plan cost take.process.plan --camera-count 12 --minutes 3 --fps 50 --json cost.json"});
  add_plan_folder(*verb, options->folder);
  add_camera_count(*verb, options->farm.cameras, 1);
  verb->add_option("--minutes", options->farm.minutes, "Its length")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  add_fps(*verb, options->farm.frame_rate, "Instants a second; 0: as the plan's take");
  verb->add_option("--node-count", options->farm.nodes, "Machines, or processes that work side by side")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return cost(*options); }; });
}

}  // namespace

void add_plan(CLI::App& app, Chosen& chosen, CommandLineReader read) {
  CLI::App* verb = add_verb(
      app, chosen, "plan", "Plans of --plan: what is in them, and their items",
      {"floatstage plan show take.process.plan", "floatstage plan run take.process.plan --item finish"});
  verb->require_subcommand(1);
  add_plan_show(*verb, chosen);
  add_plan_run(*verb, chosen, read);
  add_plan_cost(*verb, chosen);
}

}  // namespace floatstage::apps
