#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "studio/messages/studio_control.h"
#include "studio/network/keys.h"

namespace floatstage::studio::wire {

struct ControlCounters {
  std::uint64_t requests = 0;       ///< answered, refusals by the node included
  std::uint64_t malformed = 0;      ///< requests that make no sense
  std::uint64_t other_version = 0;  ///< requests of another release
  std::uint64_t refused = 0;        ///< handshakes that failed: wrong keys, or no ZeroMQ
};

/// Answers requests from the network with a node's StudioControl, one after the other, on a thread of its
/// own. A request that makes no sense is answered by a sentence that says so.
class ControlServer {
 public:
  /// `control` must outlive the server. Errors: those of check_address(), and Io where the port is taken.
  static Result<std::unique_ptr<ControlServer>> bind(const std::string& address,
                                                     const std::optional<StudioKeys>& keys,
                                                     StudioControl& control);
  ~ControlServer();
  const std::string& address() const;
  ControlCounters counters() const;

 private:
  struct Impl;
  explicit ControlServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::studio::wire
