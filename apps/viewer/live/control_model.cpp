#include "apps/viewer/live/control_model.h"

#include <algorithm>
#include <chrono>

#include "core/text.h"

namespace floatstage::apps {

Result<std::string> record_all(const std::vector<studio::StudioControl*>& nodes, const std::string& label) {
  std::string takes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    Result<std::string> take = nodes[i]->start_recording(label);
    if (!take) {
      // A take of some nodes only is of no use to anybody.
      for (std::size_t k = 0; k < i; ++k) (void)nodes[k]->stop_recording();
      return take;
    }
    takes += (takes.empty() ? "" : ", ") + *take;
  }
  return takes;
}

Result<void> stop_all(const std::vector<studio::StudioControl*>& nodes) {
  Result<void> ended;
  bool any = false;
  for (studio::StudioControl* node : nodes) {
    Result<void> one = node->stop_recording();
    any = any || one;
    const bool had_none = !one && one.error().code == ErrorCode::NotFound;
    if (!one && !had_none && ended) ended = std::move(one);
  }
  if (!any && ended) return fail(ErrorCode::NotFound, "no take is being recorded");
  return ended;
}

bool ControlModel::State::recording() const {
  return std::any_of(nodes.begin(), nodes.end(),
                     [](const studio::NodeStatus& n) { return n.recording.has_value(); });
}

ControlModel::ControlModel(std::vector<studio::StudioControl*> nodes, Nanoseconds period)
    : nodes_(std::move(nodes)) {
  if (!nodes_.empty()) thread_ = std::thread([this, period] { run(period); });
}

ControlModel::~ControlModel() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

ControlModel::State ControlModel::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void ControlModel::record(const std::string& label) { command({label}); }
void ControlModel::stop() { command({}); }

void ControlModel::command(Command command) {
  const std::lock_guard lock(mutex_);
  if (nodes_.empty() || command_) return;
  command_ = std::move(command);
  state_.busy = true;
  asked_ = false;
  wake_.notify_all();
}

void ControlModel::settle() {
  std::unique_lock lock(mutex_);
  settled_.wait(lock, [&] { return nodes_.empty() || (!command_ && asked_); });
}

void ControlModel::execute(const Command& command) {
  std::string told;
  bool failed = false;
  if (command.label) {
    const Result<std::string> takes = record_all(nodes_, *command.label);
    failed = !takes;
    told = takes ? text("recording ", *takes) : takes.error().message;
  } else {
    const Result<void> ended = stop_all(nodes_);
    failed = !ended;
    told = ended ? "recorded" : ended.error().message;
  }
  const std::lock_guard lock(mutex_);
  state_.told = std::move(told);
  state_.failed = failed;
}

std::vector<studio::NodeStatus> ControlModel::ask() const {
  std::vector<studio::NodeStatus> out;
  for (const studio::StudioControl* node : nodes_) out.push_back(node->status());
  return out;
}

void ControlModel::run(Nanoseconds period) {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    const std::optional<Command> command = command_;
    lock.unlock();
    if (command) execute(*command);
    std::vector<studio::NodeStatus> nodes = ask();
    lock.lock();
    state_.nodes = std::move(nodes);
    if (command) {
      command_.reset();
      state_.busy = false;
    }
    asked_ = !command_;
    settled_.notify_all();
    wake_.wait_for(lock, std::chrono::nanoseconds(period.count), [&] { return ending_ || command_; });
  }
}

}  // namespace floatstage::apps
