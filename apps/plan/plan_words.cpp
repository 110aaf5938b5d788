#include "apps/plan/plan_words.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/text.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;
using pipeline::ItemResult;
using pipeline::Plan;
using pipeline::PlanItem;
using pipeline::PlanStatus;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char line[512];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

const ItemResult* result_of(const PlanStatus& status, const std::string& id) {
  const auto ended = status.ended.find(id);
  return ended == status.ended.end() ? nullptr : &ended->second;
}

const char* state_of(const ItemResult* result) {
  return !result ? "waiting" : result->done ? "done" : "failed";
}

std::string frames_of(const PlanItem& item) {
  if (item.count == 0) return "";
  return text(item.first, ":", item.first + (item.count - 1) * item.step + 1,
              item.step > 1 ? text(":", item.step) : "");
}

std::string duration(double seconds) {
  if (seconds < 120) return formatted("%.0f s", seconds);
  if (seconds < 7200) return formatted("%.0f min", seconds / 60);
  return formatted("%.1f h", seconds / 3600);
}

// What puts all into one place is one process's.
bool is_alone(const Plan& plan, const pipeline::PlanStage& stage) {
  return plan.items[stage.items.front()].count == 0;
}

}  // namespace

std::string table_of(const Plan& plan, const PlanStatus& status) {
  std::string out = formatted("%-28s %-8s %-10s %-12s %9s %10s %10s %s\n", "item", "state", "cameras",
                              "frames", "seconds", "MB read", "MB written", "machine");
  for (const PlanItem& item : plan.items) {
    const ItemResult* result = result_of(status, item.id);
    const bool done = result && result->done;
    out += formatted("%-28s %-8s %-10s %-12s %8.1f%s %10.1f %10.1f %s\n", item.id.c_str(), state_of(result),
                     (item.cameras.size() == 1 ? item.cameras.front()
                      : item.cameras.empty()   ? std::string("all")
                                               : std::to_string(item.cameras.size()))
                         .c_str(),
                     frames_of(item).c_str(), done ? result->seconds : expected_seconds(item, status),
                     done ? " " : "?", 1e-6 * static_cast<double>(item.bytes_in),
                     1e-6 * static_cast<double>(done ? result->bytes : item.bytes_out),
                     result ? result->node.c_str() : "");
  }
  out += formatted("%d of %zu items done, %d failed; %.1f s of work spent, %.1f s left\n", status.done,
                   plan.items.size(), status.failed, status.spent, status.left);
  for (const std::string& remark : plan.remarks) out += remark + "\n";
  for (const PlanItem& item : plan.items)
    if (const ItemResult* result = result_of(status, item.id); result && result->error)
      out += text(item.id, ": ", result->error->message, "\n");
  return out;
}

std::string dot_of(const Plan& plan, const PlanStatus& status) {
  std::string out = "digraph plan {\n  rankdir=LR;\n  node [shape=box, style=filled];\n";
  const std::vector<pipeline::PlanStage> stages = plan.stages();
  for (std::size_t s = 0; s < stages.size(); ++s) {
    // All of a stage are done before the next begins: a point between them spares each a line to each.
    const std::string begin = text("\"before ", stages[s].name, "\""),
                      end = s + 1 < stages.size() ? text("\"before ", stages[s + 1].name, "\"") : "";
    if (s > 0) out += text("  ", begin, " [shape=point];\n");
    for (const std::size_t i : stages[s].items) {
      const PlanItem& item = plan.items[i];
      const ItemResult* result = result_of(status, item.id);
      const char* color = !result ? "white" : result->done ? "palegreen" : "salmon";
      const double seconds = result && result->done ? result->seconds : expected_seconds(item, status);
      out += text("  \"", item.id, "\" [label=\"", item.id, "\\n", duration(seconds), "\", fillcolor=", color,
                  "];\n");
      if (s > 0) out += text("  ", begin, " -> \"", item.id, "\";\n");
      if (!end.empty()) out += text("  \"", item.id, "\" -> ", end, ";\n");
    }
  }
  return out + "}\n";
}

json json_of(const Plan& plan, const PlanStatus& status) {
  json items = json::array();
  for (const PlanItem& item : plan.items) {
    const ItemResult* result = result_of(status, item.id);
    json j = {{"item", item.id},
              {"stage", item.stage},
              {"state", state_of(result)},
              {"cameras", item.cameras},
              {"frames", frames_of(item)},
              {"units", item.units},
              {"expected_seconds", expected_seconds(item, status)},
              {"bytes_in", item.bytes_in},
              {"bytes_out", item.bytes_out}};
    if (result) {
      j["seconds"] = result->seconds, j["node"] = result->node, j["attempts"] = result->attempts;
      j["bytes_written"] = result->bytes;
      if (result->error) j["error"] = result->error->message;
    }
    items.push_back(std::move(j));
  }
  return {{"command", plan.command},     {"remarks", plan.remarks},       {"items", std::move(items)},
          {"done", status.done},         {"failed", status.failed},       {"seconds_spent", status.spent},
          {"seconds_left", status.left}, {"seconds_a_unit", status.rates}};
}

Result<FarmCost> cost_of(const Plan& plan, const PlanStatus& status, const FarmSize& farm) {
  const double rate = farm.frame_rate > 0 ? farm.frame_rate : plan.frame_rate;
  const double photographs = std::round(farm.minutes * 60 * rate) * farm.cameras;
  FarmCost cost;
  for (const pipeline::PlanStage& stage : plan.stages()) {
    const auto measured = status.rates.find(stage.name);
    if (plan.cameras == 0 || measured == status.rates.end())
      return fail(ErrorCode::InvalidArgument,
                  text(plan.folder.string(), " has no finished items of the stage '", stage.name,
                       "' that say what a photograph costs; carry out a plan of `process` first"));
    const double seconds = measured->second * photographs;
    cost.seconds[stage.name] = seconds;
    cost.work += seconds;
    cost.wall += is_alone(plan, stage) ? seconds : seconds / farm.nodes;
  }
  return cost;
}

std::string sentence(const FarmCost& cost, const FarmSize& farm) {
  std::string out;
  for (const auto& [stage, seconds] : cost.seconds)
    out += formatted("%-10s %s\n", stage.c_str(), duration(seconds).c_str());
  return out + formatted("%d cameras for %g minutes: %s of work, %s on %d machines of this kind\n",
                         farm.cameras, farm.minutes, duration(cost.work).c_str(), duration(cost.wall).c_str(),
                         farm.nodes);
}

json json_of(const FarmCost& cost) {
  return {{"stages", cost.seconds}, {"work_seconds", cost.work}, {"wall_seconds", cost.wall}};
}

}  // namespace floatstage::apps
