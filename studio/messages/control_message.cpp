#include "studio/messages/control_message.h"

#include <array>

#include <nlohmann/json.hpp>

#include "core/json_fields.h"
#include "core/text.h"
#include "studio/messages/bounded_json.h"

namespace floatstage::studio::wire {
namespace {

using Json = nlohmann::ordered_json;

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

Result<std::string> seal_json(MessageKind kind, const std::string& json) {
  MessageHeader header;
  header.kind = kind;
  return seal(header, json);
}

Result<nlohmann::json> open_json(const Message& message, MessageKind kind) {
  if (message.header.kind != kind)
    return fail(ErrorCode::BadData,
                text("a ", name_of(kind), " was expected, and this is a ", name_of(message.header.kind)));
  return parse_bounded(message.payload, name_of(kind));
}

}  // namespace

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

}  // namespace floatstage::studio::wire
