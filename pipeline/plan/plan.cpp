#include "pipeline/plan/plan.h"

#include <algorithm>
#include <ctime>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/rig.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kVersion = 1;
constexpr int kMostFrames = 1 << 24;  // of an item: a week of 25 a second

json to_json(const PlanItem& item) {
  return {{"id", item.id},
          {"stage", item.stage},
          {"cameras", item.cameras},
          {"first", item.first},
          {"count", item.count},
          {"step", item.step},
          {"units", item.units},
          {"seconds", item.seconds},
          {"bytes_in", item.bytes_in},
          {"bytes_out", item.bytes_out},
          {"with", item.with}};
}

PlanItem item_of(const json& j) {
  PlanItem item{.id = j.at("id"), .stage = j.at("stage"), .cameras = j.at("cameras")};
  item.first = j.at("first"), item.count = j.at("count"), item.step = j.at("step");
  item.units = j.at("units"), item.seconds = j.at("seconds");
  item.bytes_in = j.at("bytes_in"), item.bytes_out = j.at("bytes_out");
  item.with = j.at("with");
  // Ids name files: they must not lead out of the folder.
  if (!is_usable_serial(item.id)) throw std::invalid_argument(text("'", item.id, "' names no item"));
  if (item.first < 0 || item.count < 0 || item.count > kMostFrames || item.step < 1 ||
      item.first + std::int64_t{item.count} * item.step > std::numeric_limits<int>::max())
    throw std::invalid_argument(text("item ", item.id, " has frames that no take has"));
  return item;
}

json to_json(const ItemResult& result) {
  json j = {{"state", result.done ? "done" : "failed"},
            {"attempts", result.attempts},
            {"node", result.node},
            {"seconds", result.seconds},
            {"bytes", result.bytes}};
  if (result.error)
    j["error"] = {{"code", static_cast<int>(result.error->code)},
                  {"name", name_of(result.error->code)},
                  {"message", result.error->message}};
  return j;
}

// What `read` makes of a file of ours; BadData names it.
template <class Read>
auto parsed(const fs::path& file, const Read& read) -> Result<decltype(read(json()))> {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  const Result<json> j = parse_json(*bytes, file.string());
  if (!j) return forward(j);
  try {
    return read(*j);
  } catch (const std::exception& e) {  // JSON's
    return fail(ErrorCode::BadData, text(file.string(), " is no file of a plan (", e.what(), ")"));
  }
}

}  // namespace

std::vector<int> PlanItem::frames() const {
  std::vector<int> all;
  for (int i = 0; i < count; ++i) all.push_back(first + i * step);
  return all;
}

const PlanItem* Plan::find(const std::string& id) const {
  const auto found = std::find_if(items.begin(), items.end(), [&](const PlanItem& i) { return i.id == id; });
  return found == items.end() ? nullptr : &*found;
}

std::vector<PlanStage> Plan::stages() const {
  std::vector<PlanStage> all;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (all.empty() || all.back().name != items[i].stage) all.push_back({items[i].stage, {}});
    all.back().items.push_back(i);
  }
  return all;
}

Result<Plan> load_plan(const fs::path& folder) {
  return parsed(folder / "plan.json", [&](const json& j) {
    if (j.at("floatstage_plan") != kVersion) throw std::invalid_argument("of another version");
    Plan plan;
    plan.folder = fs::absolute(folder);
    plan.command = j.at("command");
    plan.said_in = j.at("said_in").get<std::string>();
    plan.program = j.at("program");
    plan.made_from = j.at("made_from");
    plan.scratch = j.at("scratch").get<std::string>();
    plan.frame_rate = j.at("frame_rate");
    plan.cameras = j.at("cameras");
    plan.stale = j.at("stale");
    plan.remarks = j.value("remarks", plan.remarks);
    for (const json& item : j.at("items")) plan.items.push_back(item_of(item));
    if (plan.items.empty()) throw std::invalid_argument("no items");
    return plan;
  });
}

Result<void> save_plan(const Plan& plan) {
  json items = json::array();
  for (const PlanItem& item : plan.items) items.push_back(to_json(item));
  const json j = {
      {"floatstage_plan", kVersion},   {"command", plan.command},     {"said_in", plan.said_in.string()},
      {"program", plan.program},       {"made_from", plan.made_from}, {"scratch", plan.scratch.string()},
      {"frame_rate", plan.frame_rate}, {"cameras", plan.cameras},     {"stale", plan.stale},
      {"remarks", plan.remarks},       {"items", std::move(items)}};
  for (const char* inside : {"items", "logs", "done"})
    if (Result<void> ok = make_folder(plan.folder / inside); !ok) return ok;
  return write_file(plan.file(), j.dump(1) + "\n");
}

Result<std::optional<ItemResult>> load_result(const Plan& plan, const std::string& id) {
  Result<ItemResult> result = parsed(plan.result(id), [](const json& j) {
    ItemResult r{.done = j.at("state") == "done",
                 .attempts = j.at("attempts"),
                 .node = j.at("node"),
                 .seconds = j.at("seconds"),
                 .bytes = j.at("bytes"),
                 .error = {}};
    if (j.contains("error")) {
      const int code = j.at("error").at("code");
      if (code < 0 || code > static_cast<int>(ErrorCode::Cancelled))
        throw std::invalid_argument(text("error ", code, " is none"));
      r.error = Error{static_cast<ErrorCode>(code), j.at("error").at("message")};
    }
    return r;
  });
  if (!result && result.error().code == ErrorCode::NotFound) return std::optional<ItemResult>();
  if (!result) return forward(result);
  return std::optional<ItemResult>(std::move(*result));
}

Result<void> save_result(const Plan& plan, const std::string& id, const ItemResult& result) {
  return write_file(plan.result(id), to_json(result).dump(1) + "\n");
}

Result<PlanStatus> status_of(const Plan& plan, const PlanStatus& before) {
  PlanStatus status;
  std::map<std::string, std::pair<double, double>> measured;  // by stage: seconds, units
  for (const PlanItem& item : plan.items) {
    const auto known = before.ended.find(item.id);
    Result<std::optional<ItemResult>> result = known != before.ended.end() && known->second.done
                                                   ? std::optional<ItemResult>(known->second)
                                                   : load_result(plan, item.id);
    if (!result) return forward(result);
    if (!*result) continue;
    if ((*result)->done) {
      ++status.done;
      status.spent += (*result)->seconds;
      measured[item.stage].first += (*result)->seconds;
      measured[item.stage].second += item.units;
    } else {
      ++status.failed;
    }
    status.ended[item.id] = std::move(**result);
  }
  for (const auto& [stage, sums] : measured)
    if (sums.second > 0) status.rates[stage] = sums.first / sums.second;
  for (const PlanItem& item : plan.items) {
    const auto ended = status.ended.find(item.id);
    if (ended == status.ended.end() || !ended->second.done) status.left += expected_seconds(item, status);
  }
  return status;
}

double expected_seconds(const PlanItem& item, const PlanStatus& status) {
  const auto rate = status.rates.find(item.stage);
  return rate == status.rates.end() ? item.seconds : rate->second * item.units;
}

Result<void> save_status(const Plan& plan, const PlanStatus& status, int at_once) {
  json stages = json::object();
  for (const PlanStage& stage : plan.stages()) {
    int done = 0;
    for (const std::size_t i : stage.items) {
      const auto ended = status.ended.find(plan.items[i].id);
      done += ended != status.ended.end() && ended->second.done;
    }
    stages[stage.name] = {{"items", stage.items.size()}, {"done", done}};
    if (status.rates.contains(stage.name)) stages[stage.name]["seconds_a_unit"] = status.rates.at(stage.name);
  }
  json ended = json::object();
  for (const auto& [id, result] : status.ended) ended[id] = to_json(result);
  const json j = {{"written", static_cast<std::int64_t>(std::time(nullptr))},
                  {"items", plan.items.size()},
                  {"done", status.done},
                  {"failed", status.failed},
                  {"running", status.running},
                  {"seconds_spent", status.spent},
                  {"seconds_left", status.left},
                  {"at_once", at_once},
                  {"eta_seconds", status.left / std::max(1, at_once)},
                  {"stages", std::move(stages)},
                  {"ended", std::move(ended)}};
  return write_file(plan.status(), j.dump(1) + "\n");
}

}  // namespace floatstage::pipeline
