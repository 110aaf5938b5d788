#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.h"
#include "studio/messages/message.h"
#include "studio/messages/status_json.h"
#include "studio/messages/studio_control.h"

namespace floatstage::studio::wire {

/// What a node tells everybody, once a second.
Result<std::string> encode_status(const NodeStatus& status);
Result<NodeStatus> decode_status(const Message& message);

enum class Ask { Status, StartRecording, StopRecording, Takes };

struct ControlRequest {
  Ask ask = Ask::Status;
  std::string label;  ///< of StartRecording
  bool operator==(const ControlRequest&) const = default;
};

/// An answer as JSON (empty where there is nothing to say), or why not.
using ControlReply = Result<std::string>;

Result<std::string> encode_request(const ControlRequest& request);
Result<ControlRequest> decode_request(const Message& message);
Result<std::string> encode_reply(const ControlReply& reply);
/// The answer, or the node's refusal as an error with its code; BadData when the message makes no sense.
ControlReply decode_reply(const Message& message);

/// Lets a node answer. Nothing a request says makes this throw.
ControlReply answer(const ControlRequest& request, StudioControl& control);

}  // namespace floatstage::studio::wire
