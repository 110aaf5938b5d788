#include "studio/messages/status_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/json_fields.h"
#include "core/text.h"
#include "studio/messages/bounded_json.h"

namespace floatstage::studio::wire {
namespace {

using Json = nlohmann::ordered_json;

// One object of a document that other programs wrote.
class StatusFields : public JsonFields {
 public:
  StatusFields(const nlohmann::json& value, std::string where, JsonProblem& problem)
      : JsonFields(value, std::move(where), problem), problem_(problem) {}

  std::uint64_t count(const char* key) {
    const nlohmann::json* value = child(key);
    if (value && value->is_number_unsigned()) return value->get<std::uint64_t>();
    problem_.note(where(), text(key, " must be a whole number"));
    return 0;
  }
  std::optional<double> number_if_told(const char* key) {
    if (!has(key)) return std::nullopt;
    return number(key);
  }
  std::vector<std::string> strings(const char* key) {
    std::vector<std::string> found;
    if (const nlohmann::json* values = list(key))
      for (const nlohmann::json& value : *values) {
        if (value.is_string())
          found.push_back(value.get<std::string>());
        else
          problem_.note(where(), text(key, " must be a list of texts"));
      }
    return found;
  }

 private:
  JsonProblem& problem_;
};

void put_if_told(Json& json, const char* key, const std::optional<double>& value) {
  if (value && std::isfinite(*value)) json[key] = *value;
}

Json camera_json(const NodeCamera& c) {
  Json json = {{"serial", c.serial},         {"delivered", c.delivered}, {"lost", c.lost},
               {"corrupt", c.corrupt},       {"failed", c.failed},       {"starved", c.starved},
               {"reconnects", c.reconnects}, {"fps", c.frame_rate},      {"width", c.width},
               {"height", c.height},         {"trouble", c.trouble}};
  put_if_told(json, "temperature_c", c.temperature_c);
  put_if_told(json, "bandwidth_mbit", c.bandwidth_mbit);
  return json;
}

NodeCamera camera_of(const nlohmann::json& json, JsonProblem& problem) {
  StatusFields in(json, "status: camera", problem);
  NodeCamera c;
  c.serial = in.string("serial");
  c.delivered = in.count("delivered");
  c.lost = in.count("lost");
  c.corrupt = in.count("corrupt");
  c.failed = in.count("failed");
  c.starved = in.count("starved");
  c.reconnects = in.count("reconnects");
  c.frame_rate = in.number("fps");
  c.width = in.integer("width");
  c.height = in.integer("height");
  c.trouble = in.string("trouble");
  c.temperature_c = in.number_if_told("temperature_c");
  c.bandwidth_mbit = in.number_if_told("bandwidth_mbit");
  in.refuse_others();
  return c;
}

NodeSound sound_of(const nlohmann::json& json, JsonProblem& problem) {
  StatusFields in(json, "status: sound", problem);
  NodeSound s;
  s.name = in.string("name");
  s.seconds = in.number("seconds");
  s.peak = in.number("peak");
  s.ended = in.boolean("ended");
  in.refuse_others();
  return s;
}

NodeRecording recording_of(const nlohmann::json& json, JsonProblem& problem) {
  StatusFields in(json, "status: recording", problem);
  NodeRecording r;
  r.take = in.string("take");
  r.seconds = in.number("seconds");
  r.frames = in.count("frames");
  r.gaps = in.count("gaps");
  r.duplicates = in.count("duplicates");
  r.complaints = in.strings("complaints");
  if (in.has("sounds"))
    if (const nlohmann::json* sounds = in.list("sounds"))
      for (const nlohmann::json& sound : *sounds) r.sounds.push_back(sound_of(sound, problem));
  in.refuse_others();
  return r;
}

}  // namespace

std::string to_json(const NodeStatus& status) {
  Json json = {{"node", status.node},
               {"fps", status.frame_rate},
               {"spread_ms", {{"p50", status.spread_p50_ms}, {"max", status.spread_max_ms}}},
               {"disk_free_bytes", status.disk_free_bytes},
               {"preroll_seconds", status.preroll_seconds},
               {"complaints", status.complaints},
               {"last_recording", status.last_recording},
               {"cameras", Json::array()}};
  put_if_told(json, "disk_minutes", status.disk_minutes);
  for (const NodeCamera& camera : status.cameras) json["cameras"].push_back(camera_json(camera));
  if (const std::optional<NodeRecording>& r = status.recording) {
    json["recording"] = {{"take", r->take}, {"seconds", r->seconds},       {"frames", r->frames},
                         {"gaps", r->gaps}, {"duplicates", r->duplicates}, {"complaints", r->complaints}};
    // Left out where there are none: programs of before read the rest.
    for (const NodeSound& s : r->sounds)
      json["recording"]["sounds"].push_back(
          {{"name", s.name}, {"seconds", s.seconds}, {"peak", s.peak}, {"ended", s.ended}});
  }
  return print_json(json);
}

Result<NodeStatus> parse_node_status(std::string_view json) {
  const Result<nlohmann::json> parsed = parse_bounded(json, "status");
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  StatusFields in(*parsed, "status", problem);
  NodeStatus status;
  status.node = in.string("node");
  status.frame_rate = in.number("fps");
  if (const nlohmann::json* spread = in.child("spread_ms")) {
    StatusFields ms(*spread, "status: spread_ms", problem);
    status.spread_p50_ms = ms.number("p50");
    status.spread_max_ms = ms.number("max");
    ms.refuse_others();
  }
  status.disk_free_bytes = in.count("disk_free_bytes");
  status.preroll_seconds = in.number("preroll_seconds");
  status.complaints = in.strings("complaints");
  status.last_recording = in.string("last_recording");
  status.disk_minutes = in.number_if_told("disk_minutes");
  if (const nlohmann::json* cameras = in.list("cameras"))
    for (const nlohmann::json& camera : *cameras) status.cameras.push_back(camera_of(camera, problem));
  if (const nlohmann::json* recording = in.child("recording", false))
    status.recording = recording_of(*recording, problem);
  in.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return status;
}

std::string to_json(const std::vector<NodeTake>& takes) {
  Json json = Json::array();
  for (const NodeTake& take : takes)
    json.push_back({{"name", take.name},
                    {"created", take.created},
                    {"bytes", take.bytes},
                    {"complete", take.complete},
                    {"verdict", take.verdict},
                    {"seconds", take.seconds},
                    {"cameras", take.cameras}});
  return print_json(json);
}

Result<std::vector<NodeTake>> parse_node_takes(std::string_view json) {
  const Result<nlohmann::json> parsed = parse_bounded(json, "takes");
  if (!parsed) return forward(parsed);
  if (!parsed->is_array()) return fail(ErrorCode::BadData, "takes: a list was expected");
  std::vector<NodeTake> takes;
  JsonProblem problem;
  for (const nlohmann::json& json_take : *parsed) {
    StatusFields in(json_take, "takes", problem);
    NodeTake take;
    take.name = in.string("name");
    take.created = in.string("created");
    take.bytes = in.count("bytes");
    take.complete = in.boolean("complete");
    take.verdict = in.string("verdict");
    take.seconds = in.number("seconds");
    take.cameras = in.integer("cameras");
    in.refuse_others();
    takes.push_back(std::move(take));
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return takes;
}

}  // namespace floatstage::studio::wire
