#include "apps/plan/planned.h"

#include <algorithm>
#include <cstdio>
#include <thread>

#include "apps/terminal/interrupt.h"
#include "capture/sha256.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

// What of an older, finished plan lies in the folder.
void clear(const fs::path& folder) {
  std::error_code none;
  for (const char* inside : {"plan.json", "status.json", "slurm.json", "items", "logs", "done", "scratch"})
    fs::remove_all(folder / inside, none);
}

Result<bool> is_finished(const pipeline::Plan& plan) {
  const Result<pipeline::PlanStatus> status = status_of(plan);
  if (!status) return forward(status);
  return status->finished(plan);
}

Unexpected in_the_way(const fs::path& folder, const std::string& why) {
  return fail(ErrorCode::AlreadyExists,
              text(folder.string(), " holds an unfinished plan ", why,
                   "; remove the folder to begin anew (what is in the take already stays)"));
}

// The plan that lies there, if it is this one and not finished.
Result<std::optional<pipeline::Plan>> earlier_plan(const fs::path& folder, const pipeline::Plan& wanted,
                                                   const Planned& planned) {
  if (!is_there(folder / "plan.json")) return std::optional<pipeline::Plan>();
  Result<pipeline::Plan> plan = pipeline::load_plan(folder);
  if (!plan) return forward(plan);
  const Result<bool> finished = is_finished(*plan);
  if (!finished) return forward(finished);
  if (*finished) return std::optional<pipeline::Plan>();
  if (plan->command != wanted.command || plan->said_in != wanted.said_in)
    return in_the_way(folder, "of another command");
  if (plan->program != wanted.program) return in_the_way(folder, "of another version of this program");
  const Result<std::string> made_from = planned.made_from();
  if (!made_from) return forward(made_from);
  if (plan->made_from != *made_from) return in_the_way(folder, "of the take as it was before it was changed");
  plan->scratch = wanted.scratch;
  return std::optional<pipeline::Plan>(std::move(*plan));
}

Result<pipeline::Plan> settle_plan(pipeline::Plan wanted, const Planned& planned, int chunk) {
  Result<std::optional<pipeline::Plan>> earlier = earlier_plan(wanted.folder, wanted, planned);
  if (!earlier) return forward(earlier);
  if (*earlier) {
    if (Result<void> ok = save_plan(**earlier); !ok) return forward(ok);
    return std::move(**earlier);
  }
  Result<pipeline::Plan> made = planned.make(chunk);
  if (!made) return made;
  clear(wanted.folder);
  made->folder = wanted.folder, made->command = wanted.command, made->said_in = wanted.said_in;
  made->program = wanted.program, made->scratch = wanted.scratch;
  if (Result<void> ok = save_plan(*made); !ok) return forward(ok);
  return made;
}

// The last item's words, and what the verb ends with.
Result<void> end_as_the_verb(const pipeline::Plan& plan) {
  const std::string& last = plan.items.back().id;
  const Result<std::string> said = read_file(plan.log(last));
  if (said) std::fputs(said->c_str(), stdout);
  const Result<pipeline::PlanStatus> status = status_of(plan);
  if (!status) return forward(status);
  std::printf("%zu items in %.1f s of work; how long each took: floatstage plan show %s\n", plan.items.size(),
              status->spent, plan.folder.c_str());
  std::error_code none;
  for (const char* inside : {"done", "scratch"}) fs::remove_all(plan.folder / inside, none);
  const pipeline::ItemResult& result = status->ended.at(last);
  return result.error ? Result<void>(Unexpected{*result.error}) : Result<void>();
}

int usual_workers(const PlanFlags& flags, int threads) {
  if (flags.workers > 0) return flags.workers;
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  return threads > 0 ? std::max(1, cores / threads) : 1;
}

}  // namespace

fs::path this_program() {
  std::error_code none;
  return fs::read_symlink("/proc/self/exe", none);
}

bool may_go_well_again(ErrorCode code) {
  return code == ErrorCode::Io || code == ErrorCode::Timeout || code == ErrorCode::Disconnected ||
         code == ErrorCode::Cancelled;
}

fs::path plan_beside(const fs::path& of, const char* verb) {
  std::string name = of.string();
  while (name.size() > 1 && name.ends_with('/')) name.pop_back();  // beside it, not inside
  return text(name, ".", verb, ".plan");
}

Result<void> PlannedRun::operator()() const {
  return flags.backend.empty() ? alone() : run_planned(words, planned(), flags);
}

Result<ItemEnd> end_of(const Result<void>& verb) {
  if (!verb && may_go_well_again(verb.error().code)) return forward(verb);
  ItemEnd end;
  if (!verb) end.verdict = verb.error();
  return end;
}

Unexpected not_done(const pipeline::Plan& plan, const pipeline::PlanStatus& status) {
  for (const pipeline::PlanItem& item : plan.items) {
    const auto ended = status.ended.find(item.id);
    if (ended == status.ended.end() || ended->second.done || !ended->second.error) continue;
    return fail(ended->second.error->code,
                text("item ", item.id, " failed on ", ended->second.node, ": ", ended->second.error->message,
                     " (", plan.log(item.id).string(), "); the same command goes on"));
  }
  return fail(ErrorCode::Io,
              text("not all items of ", plan.folder.string(), " were carried out; the same command goes on"));
}

Result<void> run_planned(const std::vector<std::string>& words, const Planned& planned,
                         const PlanFlags& flags) {
  const Result<capture::FileHash> program =
      capture::sha256_of_file("/proc/self/exe", [](std::uint64_t) { return true; });
  if (!program) return forward(program);
  pipeline::Plan wanted;
  wanted.folder = fs::absolute(flags.folder.empty() ? planned.folder : flags.folder).lexically_normal();
  wanted.command = without_plan_flags(words);
  wanted.said_in = fs::current_path();
  wanted.program = program->sha256;
  if (!flags.scratch.empty()) wanted.scratch = fs::absolute(flags.scratch);
  if (Result<void> ok = make_folder(wanted.folder); !ok) return ok;
  bool said = false;
  const Result<Claim> claim = wait_for_folder(wanted.folder, [&] {
    if (!said) log::info(text("another run carries out ", wanted.folder.string(), "; this one waits for it"));
    said = true;
    return !interrupted();
  });
  if (!claim) return forward(claim);
  const Result<pipeline::Plan> plan = settle_plan(std::move(wanted), planned, flags.chunk);
  if (!plan) return forward(plan);
  Result<void> done = flags.backend == "slurm"
                          ? run_on_slurm(*plan, flags)
                          : run_on_this_machine(*plan, usual_workers(flags, planned.threads), flags.retries);
  return done ? end_as_the_verb(*plan) : done;
}

}  // namespace floatstage::apps
