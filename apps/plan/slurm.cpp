#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <sys/wait.h>

#include "apps/plan/planned.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/joined.h"
#include "apps/terminal/progress_bar.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/log.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::Plan;
using pipeline::PlanStatus;

constexpr std::chrono::milliseconds kLook(1000);
constexpr std::size_t kLargestArray = 1000;  // Slurm's own limit is 1001, unless MaxArraySize says otherwise

struct Said {
  int code = -1;
  std::string words;
};

// A program of Slurm's with its words on both streams.
Said ask(const std::string& command) {
  Said said;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return said;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    said.words.append(buffer.data(), n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) said.code = WEXITSTATUS(status);
  return said;
}

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// One job array: task k is the k-th item.
struct Array {
  std::string job;
  std::vector<std::string> items;
};

// What is in slurm.json: the arrays that were submitted last, so that another run follows them.
Result<void> remember(const Plan& plan, const std::vector<Array>& arrays) {
  json j = json::array();
  for (const Array& array : arrays) j.push_back({{"job", array.job}, {"items", array.items}});
  return write_file(plan.folder / "slurm.json", j.dump(1) + "\n");
}

std::vector<Array> remembered(const Plan& plan) {
  const Result<std::string> bytes = read_file(plan.folder / "slurm.json");
  if (!bytes) return {};
  std::vector<Array> arrays;
  try {
    for (const json& j : parse_json(*bytes, "slurm.json").value())
      arrays.push_back({j.at("job"), j.at("items")});
  } catch (const std::exception&) {
    return {};  // the items themselves say what is done
  }
  return arrays;
}

// Submits one plan's items and follows them.
class Farm {
 public:
  Farm(const Plan& plan, const PlanFlags& flags) : plan_(plan), flags_(flags) {}

  Result<void> run() {
    if (const Said version = ask("sbatch --version"); version.code != 0)
      return fail(ErrorCode::Unsupported, text("this machine has no Slurm (sbatch --version: ", version.words,
                                               "); install slurm-client, or say --plan local"));
    if (Result<void> ok = look(); !ok) return ok;
    arrays_ = remembered(plan_);
    ProgressBar bar;
    pipeline::ProgressPart progress(&bar, "items", plan_.items.size());
    shown_ = &progress;
    for (int round = 0; !status_.finished(plan_); ++round) {
      if (running().empty()) {
        if (round > flags_.retries) return not_done(plan_, status_);
        if (Result<void> ok = submit(); !ok) return ok;
      }
      if (Result<void> ok = follow(); !ok) return ok;
      if (status_.finished(plan_)) break;
      if (somebody_cancelled()) {
        cancel_all();
        return fail(ErrorCode::Cancelled,
                    text("jobs of ", plan_.folder.string(), " were cancelled; the same command goes on"));
      }
      for (const auto& [id, result] : status_.ended)
        if (!result.done && result.error && !may_go_well_again(result.error->code))
          return not_done(plan_, status_);
    }
    return {};
  }

 private:
  bool is_done(const std::string& id) const {
    const auto ended = status_.ended.find(id);
    return ended != status_.ended.end() && ended->second.done;
  }

  std::string all_jobs() const {
    std::vector<std::string> ids;
    for (const Array& array : arrays_) ids.push_back(array.job);
    return joined(ids, ",");
  }

  // Arrays of what is left, stage after stage. A stage begins when that before it has ended, well or not:
  // an item looks itself whether what it needs is done.
  Result<void> submit() {
    arrays_.clear();
    std::string after;
    for (const pipeline::PlanStage& stage : plan_.stages()) {
      std::vector<std::string> left, jobs;
      for (const std::size_t i : stage.items)
        if (!is_done(plan_.items[i].id)) left.push_back(plan_.items[i].id);
      for (std::size_t first = 0; first < left.size(); first += kLargestArray) {
        const std::size_t end = std::min(left.size(), first + kLargestArray);
        Array array{"",
                    {left.begin() + static_cast<std::ptrdiff_t>(first),
                     left.begin() + static_cast<std::ptrdiff_t>(end)}};
        Result<std::string> job = submit_array(stage.name, array.items, after);
        if (!job) return cancel_all(), forward(job);
        jobs.push_back(*job);
        array.job = std::move(*job);
        arrays_.push_back(std::move(array));
        if (Result<void> ok = remember(plan_, arrays_); !ok) return cancel_all(), ok;
      }
      if (!jobs.empty()) after = joined(jobs, ":");
    }
    return {};
  }

  Result<std::string> submit_array(const std::string& stage, const std::vector<std::string>& items,
                                   const std::string& after) {
    const fs::path script = plan_.folder / text("slurm-", stage, "-", arrays_.size(), ".sh");
    std::string words = "#!/bin/sh\ncase $SLURM_ARRAY_TASK_ID in\n";
    for (std::size_t i = 0; i < items.size(); ++i) words += text(i, ") item=", items[i], " ;;\n");
    words += text("esac\nexec ", quoted(this_program()), " plan run ", quoted(plan_.folder),
                  " --item \"$item\" >> ", quoted(plan_.folder / "logs"), "/\"$item\".log 2>&1\n");
    if (Result<void> ok = write_file(script, words); !ok) return forward(ok);
    std::string command =
        text("sbatch --parsable --requeue --open-mode=append --job-name=floatstage-", stage, " --array=0-",
             items.size() - 1, " --output=", quoted(plan_.folder / "logs" / "slurm-%A.log"));
    if (!after.empty()) command += " --dependency=afterany:" + after;
    command += " " + flags_.sbatch;
    const std::string avoided =
        bad_nodes_.empty() ? "" : " --exclude=" + joined({bad_nodes_.begin(), bad_nodes_.end()}, ",");
    Said said = ask(command + avoided + " " + quoted(script));
    if (said.code != 0 && !avoided.empty()) said = ask(command + " " + quoted(script));  // none was left
    if (said.code != 0)
      return fail(ErrorCode::Io, text("Slurm does not take the jobs (", command, "): ", said.words));
    return said.words.substr(0, said.words.find_first_of(";\n"));
  }

  // Items that Slurm has not ended yet, and where they are.
  std::map<std::string, std::string> running() {
    std::map<std::string, std::string> where;
    if (arrays_.empty()) return where;
    const Said said = ask("squeue --noheader --array --format='%F %K %T %N' --jobs=" + all_jobs());
    const bool forgotten = said.words.find("Invalid job id") != std::string::npos;
    if (said.code != 0 && !forgotten) return status_.running;  // the controller is away: as it was
    std::istringstream lines(said.code == 0 ? said.words : "");
    std::string job, state, line;
    std::size_t task;
    while (std::getline(lines, line)) {
      std::istringstream words(line);
      std::string node;
      if (!(words >> job >> task >> state)) continue;
      words >> node;
      for (const Array& array : arrays_)
        if (array.job == job && task < array.items.size())
          where[array.items[task]] = state == "RUNNING" ? node : state;
    }
    return where;
  }

  Result<void> look() {
    Result<PlanStatus> now = status_of(plan_, status_);
    if (!now) return forward(now);
    if (shown_ && now->done > status_.done)
      shown_->advance(static_cast<std::size_t>(now->done - status_.done));
    status_ = std::move(*now);
    return {};
  }

  Result<void> follow() {
    for (;;) {
      std::map<std::string, std::string> left = running();
      if (Result<void> ok = look(); !ok) return ok;
      avoid_bad_nodes();
      int at_once = 0;
      for (const auto& [id, where] : left) at_once += where != "PENDING";
      const bool over = left.empty();
      status_.running = std::move(left);
      if (Result<void> ok = save_status(plan_, status_, at_once); !ok) return ok;
      if (over) return {};
      if (interrupted()) return cancel_all(), pipeline::cancelled();
      std::this_thread::sleep_for(kLook);
    }
  }

  // A machine that cannot write fails at one item after the other, quicker than the others do them.
  void avoid_bad_nodes() {
    const std::size_t known = bad_nodes_.size();
    for (const auto& [id, result] : status_.ended)
      if (!result.done && result.error && result.error->code == ErrorCode::Io) bad_nodes_.insert(result.node);
    if (bad_nodes_.size() == known) return;
    const std::string nodes = joined({bad_nodes_.begin(), bad_nodes_.end()}, ",");
    log::warning(text("no more items for ", nodes, ": they could not be written there"));
    for (const Array& array : arrays_) ask(text("scontrol update JobId=", array.job, " ExcNodeList=", nodes));
  }

  bool somebody_cancelled() const {
    for (const Array& array : arrays_)
      if (ask("scontrol --oneliner show job " + array.job).words.find("JobState=CANCELLED") !=
          std::string::npos)
        return true;
    return false;
  }

  void cancel_all() {
    if (arrays_.empty()) return;
    std::string jobs = all_jobs();
    std::replace(jobs.begin(), jobs.end(), ',', ' ');
    ask("scancel " + jobs);
  }

  const Plan& plan_;
  const PlanFlags& flags_;
  PlanStatus status_;
  std::vector<Array> arrays_;
  std::set<std::string> bad_nodes_;
  pipeline::ProgressPart* shown_ = nullptr;
};

}  // namespace

Result<void> run_on_slurm(const Plan& plan, const PlanFlags& flags) { return Farm(plan, flags).run(); }

}  // namespace floatstage::apps
