#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "core/time.h"
#include "studio/messages/studio_control.h"
#include "studio/network/keys.h"

namespace floatstage::studio::wire {

/// A node on another machine, by its ControlServer. Each question makes a connection of its own, so that a
/// node that was started again is found again. Where no answer comes in time: Timeout, with a sentence that
/// names the address; status() then has that sentence as its complaint.
class ControlClient final : public StudioControl {
 public:
  /// Errors: those of check_address().
  static Result<std::unique_ptr<ControlClient>> connect(const std::string& address,
                                                        const std::optional<StudioKeys>& keys,
                                                        Nanoseconds patience = milliseconds(3000));

  NodeStatus status() const override;
  Result<NodeStatus> ask_status() const;
  Result<std::string> start_recording(const std::string& label) override;
  Result<void> stop_recording() override;
  Result<std::vector<NodeTake>> takes() const override;

 private:
  ControlClient(std::string address, std::optional<StudioKeys> keys, Nanoseconds patience)
      : address_(std::move(address)), keys_(std::move(keys)), patience_(patience) {}

  const std::string address_;
  const std::optional<StudioKeys> keys_;
  const Nanoseconds patience_;
};

}  // namespace floatstage::studio::wire
