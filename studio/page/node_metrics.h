#pragma once

#include <string>

#include "studio/messages/studio_control.h"

namespace floatstage::studio {

/// What a node's page counts about itself.
struct PageCounters {
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;  ///< without the token, or with a wrong one
  std::uint64_t viewers = 0;  ///< open live connections
  std::uint64_t dropped = 0;  ///< messages that a slow viewer did not get
};

/// A node in Prometheus' text format (https://prometheus.io/docs/instrumenting/exposition_formats/).
std::string prometheus_text(const NodeStatus& status, const PageCounters& page);

}  // namespace floatstage::studio
