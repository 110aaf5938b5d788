#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <map>
#include <thread>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/plan/planned.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/progress_bar.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

using pipeline::ItemResult;
using pipeline::Plan;
using pipeline::PlanStatus;

constexpr std::chrono::milliseconds kLook(20);

// `plan run` of one item, with its words in the item's log. It ends when we do.
Result<pid_t> start(const Plan& plan, const std::string& id) {
  const std::string program = this_program(), folder = plan.folder, log = plan.log(id);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) return fail(ErrorCode::Io, text("cannot begin a process: ", std::strerror(errno)));
  if (child > 0) return child;
  setpgid(0, 0);  // Ctrl-C is ours to pass on, once
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  if (out >= 0) dup2(out, STDOUT_FILENO), dup2(out, STDERR_FILENO);
  execl(program.c_str(), program.c_str(), "plan", "run", folder.c_str(), "--item", id.c_str(),
        static_cast<char*>(nullptr));
  _exit(127);
}

// The items of one plan on their way through processes.
class Pool {
 public:
  Pool(const Plan& plan, int workers, int retries) : plan_(plan), workers_(workers), retries_(retries) {}

  Result<void> run() {
    Result<PlanStatus> status = status_of(plan_);
    if (!status) return forward(status);
    status_ = std::move(*status);
    for (const pipeline::PlanStage& stage : plan_.stages())
      if (Result<void> ok = run_stage(stage); !ok) return ok;
    return {};
  }

 private:
  bool is_done(const std::string& id) const {
    const auto ended = status_.ended.find(id);
    return ended != status_.ended.end() && ended->second.done;
  }

  Result<void> run_stage(const pipeline::PlanStage& stage) {
    for (const std::size_t i : stage.items)
      if (!is_done(plan_.items[i].id)) waiting_.push_back(plan_.items[i].id);
    ProgressBar bar;
    pipeline::ProgressPart progress(&bar, stage.name, waiting_.size());
    bool failed = false;
    while (!waiting_.empty() || !running_.empty()) {
      if (interrupted()) return stop();
      while (!failed && !waiting_.empty() && static_cast<int>(running_.size()) < workers_)
        if (Result<void> ok = start_next(); !ok) return stop(), ok;
      if (failed && running_.empty()) break;
      Result<int> ended = collect(failed);
      if (!ended) return stop(), forward(ended);
      if (*ended > 0) progress.advance(static_cast<std::size_t>(*ended));
      std::this_thread::sleep_for(kLook);
    }
    return failed ? Result<void>(not_done(plan_, status_)) : Result<void>();
  }

  Result<void> start_next() {
    const std::string id = waiting_.front();
    const Result<pid_t> child = start(plan_, id);
    if (!child) return forward(child);
    waiting_.pop_front();
    running_[*child] = id;
    return write();
  }

  // How many came to their end; those that may go well again wait once more.
  Result<int> collect(bool& failed) {
    int ended = 0;
    for (auto it = running_.begin(); it != running_.end();) {
      int how = 0;
      if (waitpid(it->first, &how, WNOHANG) == 0) {
        ++it;
        continue;
      }
      const std::string id = it->second;
      it = running_.erase(it);
      const Result<bool> again = settle(id, how);
      if (!again) return forward(again);
      if (*again) waiting_.push_back(id);
      failed = failed || (!*again && !is_done(id));
      ended += !*again;
      if (Result<void> ok = write(); !ok) return forward(ok);
    }
    return ended;
  }

  // Whether the item is to be tried again.
  Result<bool> settle(const std::string& id, int how) {
    Result<std::optional<ItemResult>> result = load_result(plan_, id);
    if (!result) return forward(result);
    const bool killed = WIFSIGNALED(how) || !*result;
    if (killed && !(*result && (*result)->done)) {
      ItemResult lost = result->value_or(ItemResult());
      ++lost.attempts;
      lost.node = "this machine";
      lost.error = Error{ErrorCode::Io, WIFSIGNALED(how) ? text("it was ended by signal ", WTERMSIG(how))
                                                         : text("it ended with ", WEXITSTATUS(how))};
      if (Result<void> ok = save_result(plan_, id, lost); !ok) return forward(ok);
      *result = lost;
    }
    Result<PlanStatus> now = status_of(plan_, status_);
    if (!now) return forward(now);
    status_ = std::move(*now);
    if ((*result)->done) return false;
    return may_go_well_again((*result)->error->code) && ++tries_[id] <= retries_;
  }

  Result<void> write() {
    status_.running.clear();
    for (const auto& [pid, id] : running_) status_.running[id] = text("process ", pid);
    return save_status(plan_, status_, workers_);
  }

  Unexpected stop() {
    for (const auto& [pid, id] : running_) kill(pid, SIGTERM);
    for (const auto& [pid, id] : running_) waitpid(pid, nullptr, 0);
    running_.clear();
    (void)write();
    return pipeline::cancelled();
  }

  const Plan& plan_;
  const int workers_, retries_;
  PlanStatus status_;
  std::deque<std::string> waiting_;
  std::map<pid_t, std::string> running_;
  std::map<std::string, int> tries_;
};

}  // namespace

Result<void> run_on_this_machine(const Plan& plan, int workers, int retries) {
  return Pool(plan, workers, retries).run();
}

}  // namespace floatstage::apps
