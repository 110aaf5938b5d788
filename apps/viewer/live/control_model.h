#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/time.h"
#include "studio/messages/studio_control.h"

namespace floatstage::apps {

/// Begins a take on every node, in their order, or on none: where one refuses, those that have begun end
/// theirs. Returns the takes' names, separated by commas. Errors: that of the node that refused.
Result<std::string> record_all(const std::vector<studio::StudioControl*>& nodes, const std::string& label);

/// Ends the takes of all nodes that record. Errors: the first, when all were asked.
Result<void> stop_all(const std::vector<studio::StudioControl*>& nodes);

/// The operator's model: how the camera nodes do, asked about once a second, and record and stop for all of
/// them together. A thread of its own asks, so that a node that is slow, or gone, never holds up the picture.
class ControlModel {
 public:
  struct State {
    std::vector<studio::NodeStatus> nodes =
        {};                 ///< what they answered last, in their order; empty before they did
    bool busy = false;      ///< record or stop is under way
    std::string told = {};  ///< how the last of them ended
    bool failed = false;    ///< it did not end well
    bool recording() const;
  };

  /// The nodes outlive the model. None: there is nothing to control.
  explicit ControlModel(std::vector<studio::StudioControl*> nodes, Nanoseconds period = milliseconds(1000));
  /// Waits for a command that is under way. Takes go on.
  ~ControlModel();

  bool empty() const { return nodes_.empty(); }
  State state() const;
  /// Both are left out while a command is under way.
  void record(const std::string& label);
  void stop();
  /// Waits until nothing is under way and the nodes were asked since.
  void settle();

 private:
  struct Command {
    std::optional<std::string> label;  // of the take that begins; absent: stop
  };
  void run(Nanoseconds period);
  void command(Command command);
  void execute(const Command& command);
  std::vector<studio::NodeStatus> ask() const;

  const std::vector<studio::StudioControl*> nodes_;
  mutable std::mutex mutex_;  // over what follows
  std::condition_variable wake_, settled_;
  State state_;
  std::optional<Command> command_;
  bool ending_ = false, asked_ = false;
  std::thread thread_;
};

}  // namespace floatstage::apps
