#include "apps/studio/wire/control_message.h"

#include <array>

#include <nlohmann/json.hpp>

#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::wire {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestJson = 1 << 20;
constexpr int kDeepestJson = 16;

struct AskName {
  Ask ask;
  const char* name;
};
constexpr std::array<AskName, 4> kAsks = {{{Ask::Status, "status"},
                                           {Ask::StartRecording, "start-recording"},
                                           {Ask::StopRecording, "stop-recording"},
                                           {Ask::Takes, "takes"}}};

constexpr std::array kCodes = {ErrorCode::InvalidArgument, ErrorCode::NotFound,     ErrorCode::AlreadyExists,
                               ErrorCode::BadData,         ErrorCode::Unsupported,  ErrorCode::Io,
                               ErrorCode::Timeout,         ErrorCode::Disconnected, ErrorCode::EndOfStream,
                               ErrorCode::Cancelled};

// A parser asks the machine's stack for every level: more than any message of ours has is refused unread.
bool is_deep(std::string_view json) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted && c == '\\')
      ++i;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '[' || c == '{') && ++depth > kDeepestJson)
      return true;
    else if (!quoted && (c == ']' || c == '}'))
      --depth;
  }
  return false;
}

Result<nlohmann::json> parse(std::string_view json, const char* what) {
  if (json.size() > kLongestJson || is_deep(json))
    return fail(ErrorCode::BadData, text(what, ": larger or deeper than any message of ours"));
  return parse_json(json, what);
}

std::uint64_t count_of(JsonFields& fields, const char* key, JsonProblem& problem) {
  const nlohmann::json* value = fields.child(key);
  if (value && value->is_number_unsigned()) return value->get<std::uint64_t>();
  problem.note(fields.where(), text(key, " must be a whole number"));
  return 0;
}

Json camera_json(const NodeCamera& c) {
  Json json = {{"serial", c.serial},   {"delivered", c.delivered}, {"lost", c.lost},
               {"corrupt", c.corrupt}, {"failed", c.failed},       {"reconnects", c.reconnects},
               {"fps", c.frame_rate},  {"trouble", c.trouble}};
  if (c.temperature_c) json["temperature_c"] = *c.temperature_c;
  if (c.bandwidth_mbit) json["bandwidth_mbit"] = *c.bandwidth_mbit;
  return json;
}

NodeCamera camera_of(const nlohmann::json& json, JsonProblem& problem) {
  JsonFields in(json, "status: camera", problem);
  NodeCamera c;
  c.serial = in.string("serial");
  c.delivered = count_of(in, "delivered", problem);
  c.lost = count_of(in, "lost", problem);
  c.corrupt = count_of(in, "corrupt", problem);
  c.failed = count_of(in, "failed", problem);
  c.reconnects = count_of(in, "reconnects", problem);
  c.frame_rate = in.number("fps");
  c.trouble = in.string("trouble");
  if (in.has("temperature_c")) c.temperature_c = in.number("temperature_c");
  if (in.has("bandwidth_mbit")) c.bandwidth_mbit = in.number("bandwidth_mbit");
  in.refuse_others();
  return c;
}

Result<std::string> seal_json(MessageKind kind, const std::string& json) {
  MessageHeader header;
  header.kind = kind;
  return seal(header, json);
}

Result<nlohmann::json> open_json(const Message& message, MessageKind kind) {
  if (message.header.kind != kind)
    return fail(ErrorCode::BadData,
                text("a ", name_of(kind), " was expected, and this is a ", name_of(message.header.kind)));
  return parse(message.payload, name_of(kind));
}

}  // namespace

std::string to_json(const NodeStatus& status) {
  Json json = {{"node", status.node},
               {"spread_ms", {{"p50", status.spread_p50_ms}, {"max", status.spread_max_ms}}},
               {"disk_free_bytes", status.disk_free_bytes},
               {"cameras", Json::array()}};
  for (const NodeCamera& camera : status.cameras) json["cameras"].push_back(camera_json(camera));
  if (status.recording)
    json["recording"] = {{"take", status.recording->take},
                         {"seconds", status.recording->seconds},
                         {"frames", status.recording->frames},
                         {"gaps", status.recording->gaps}};
  return print_json(json);
}

Result<NodeStatus> parse_node_status(std::string_view json) {
  const Result<nlohmann::json> parsed = parse(json, "status");
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  JsonFields in(*parsed, "status", problem);
  NodeStatus status;
  status.node = in.string("node");
  if (const nlohmann::json* spread = in.child("spread_ms")) {
    JsonFields ms(*spread, "status: spread_ms", problem);
    status.spread_p50_ms = ms.number("p50");
    status.spread_max_ms = ms.number("max");
    ms.refuse_others();
  }
  status.disk_free_bytes = count_of(in, "disk_free_bytes", problem);
  if (const nlohmann::json* cameras = in.list("cameras"))
    for (const nlohmann::json& camera : *cameras) status.cameras.push_back(camera_of(camera, problem));
  if (const nlohmann::json* recording = in.child("recording", false)) {
    JsonFields r(*recording, "status: recording", problem);
    status.recording = NodeRecording{r.string("take"), r.number("seconds"), count_of(r, "frames", problem),
                                     count_of(r, "gaps", problem)};
    r.refuse_others();
  }
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
                    {"verdict", take.verdict}});
  return print_json(json);
}

Result<std::vector<NodeTake>> parse_node_takes(std::string_view json) {
  const Result<nlohmann::json> parsed = parse(json, "takes");
  if (!parsed) return forward(parsed);
  if (!parsed->is_array()) return fail(ErrorCode::BadData, "takes: a list was expected");
  std::vector<NodeTake> takes;
  JsonProblem problem;
  for (const nlohmann::json& take : *parsed) {
    JsonFields in(take, "takes", problem);
    takes.push_back({in.string("name"), in.string("created"), count_of(in, "bytes", problem),
                     in.boolean("complete"), in.string("verdict")});
    in.refuse_others();
  }
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return takes;
}

Result<std::string> encode_status(const NodeStatus& status) {
  return seal_json(MessageKind::Status, to_json(status));
}

Result<NodeStatus> decode_status(const Message& message) {
  if (message.header.kind != MessageKind::Status) return fail(ErrorCode::BadData, "the message is no status");
  return parse_node_status(message.payload);
}

Result<std::string> encode_request(const ControlRequest& request) {
  Json json;
  for (const AskName& a : kAsks)
    if (a.ask == request.ask) json["ask"] = a.name;
  if (!request.label.empty()) json["label"] = request.label;
  return seal_json(MessageKind::Request, print_json(json));
}

Result<ControlRequest> decode_request(const Message& message) {
  const Result<nlohmann::json> parsed = open_json(message, MessageKind::Request);
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  JsonFields in(*parsed, "request", problem);
  ControlRequest request;
  const std::string ask = in.string("ask");
  if (in.has("label")) request.label = in.string("label");
  in.refuse_others();
  bool found = false;
  std::string understood;
  for (const AskName& a : kAsks) {
    if (ask == a.name) {
      request.ask = a.ask;
      found = true;
    }
    understood += text(understood.empty() ? "" : ", ", a.name);
  }
  if (!found) problem.note("request", text("'", ask, "' is not understood; there are ", understood));
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return request;
}

Result<std::string> encode_reply(const ControlReply& reply) {
  Json json;
  if (reply)
    json["answer"] = *reply;
  else
    json["refused"] = {{"code", name_of(reply.error().code)}, {"message", reply.error().message}};
  return seal_json(MessageKind::Reply, print_json(json));
}

ControlReply decode_reply(const Message& message) {
  const Result<nlohmann::json> parsed = open_json(message, MessageKind::Reply);
  if (!parsed) return forward(parsed);
  JsonProblem problem;
  JsonFields in(*parsed, "reply", problem);
  std::string said;
  ErrorCode code = ErrorCode::BadData;
  const bool refused = in.has("refused");
  if (const nlohmann::json* refusal = in.child("refused", false)) {
    JsonFields why(*refusal, "reply: refused", problem);
    const std::string name = why.string("code");
    said = why.string("message");
    why.refuse_others();
    for (ErrorCode known : kCodes)
      if (name == name_of(known)) code = known;
  } else {
    said = in.string("answer");
  }
  in.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  if (refused) return fail(code, said);
  return said;
}

ControlReply answer(const ControlRequest& request, StudioControl& control) {
  switch (request.ask) {
    case Ask::Status:
      return to_json(control.status());
    case Ask::StartRecording:
      return control.start_recording(request.label);
    case Ask::StopRecording: {
      const Result<void> stopped = control.stop_recording();
      if (!stopped) return forward(stopped);
      return std::string();
    }
    case Ask::Takes: {
      const Result<std::vector<NodeTake>> takes = control.takes();
      if (!takes) return forward(takes);
      return to_json(*takes);
    }
  }
  return fail(ErrorCode::InvalidArgument, "a request that is not understood");
}

}  // namespace floatstage::wire
