#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "studio/messages/studio_control.h"

namespace floatstage::studio::wire {

/// The JSON of a node's status: of the network, and of the node's page. What a device does not tell is not in
/// it.
std::string to_json(const NodeStatus& status);
Result<NodeStatus> parse_node_status(std::string_view json);
std::string to_json(const std::vector<NodeTake>& takes);
Result<std::vector<NodeTake>> parse_node_takes(std::string_view json);

}  // namespace floatstage::studio::wire
