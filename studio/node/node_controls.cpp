// CaptureNode: what an operator turns, and keeps.
#include <algorithm>
#include <iterator>
#include <map>

#include "core/text.h"
#include "studio/node/camera_presets.h"
#include "studio/node/capture_node.h"

namespace floatstage::studio {
namespace {

Result<void> has_presets(const CaptureConfig& config) {
  if (!config.presets.empty()) return {};
  return fail(
      ErrorCode::Unsupported,
      "there is no file for presets; add presets = \"presets.toml\" to [studio] of the studio's file");
}

// What one knob frees another takes (a gain, once its automatic is off): what was refused is tried again.
Result<void> set_all(CaptureNode& node, const std::string& serial, std::map<std::string, double> wanted) {
  for (bool again = true;; again = false) {
    Result<void> first;
    for (auto next = wanted.begin(); next != wanted.end();) {
      const Result<void> set = node.set_control(serial, next->first, next->second);
      if (!set && set.error().code == ErrorCode::Timeout) return set;
      if (!set && first) first = set;
      next = set ? wanted.erase(next) : std::next(next);
    }
    if (first || !again) return first;
  }
}

}  // namespace

std::vector<NodeControls> CaptureNode::controls() const {
  std::vector<NodeControls> all;
  for (const auto& lane : lanes_) all.push_back({lane->serial(), lane->controls()});
  return all;
}

Result<void> CaptureNode::set_control(const std::string& serial, const std::string& name, double value) {
  const auto lane =
      std::find_if(lanes_.begin(), lanes_.end(), [&](const auto& l) { return l->serial() == serial; });
  if (lane == lanes_.end()) return fail(ErrorCode::NotFound, text("there is no camera '", serial, "'"));
  return (*lane)->set_control(name, value);
}

Result<std::vector<std::string>> CaptureNode::presets() const {
  std::vector<std::string> names;
  if (config_.presets.empty()) return names;
  std::lock_guard lock(presets_);
  const Result<CameraPresets> all = load_presets(config_.presets);
  if (!all) return forward(all);
  for (const auto& [name, preset] : *all) names.push_back(name);
  return names;
}

Result<void> CaptureNode::save_preset(const std::string& name) {
  if (Result<void> ok = has_presets(config_); !ok) return ok;
  if (!is_preset_name(name))
    return fail(ErrorCode::InvalidArgument, "a preset's name is 1 to 60 letters, digits, '.', '-' and '_'");
  std::lock_guard lock(presets_);
  Result<CameraPresets> all = load_presets(config_.presets);
  if (!all) return forward(all);
  CameraPreset preset;
  for (const NodeControls& camera : controls())
    for (const capture::CameraControl& control : camera.controls)
      preset[camera.serial][control.name] = control.value;
  (*all)[name] = std::move(preset);
  return save_presets(*all, config_.presets);
}

Result<void> CaptureNode::apply_preset(const std::string& name) {
  if (Result<void> ok = has_presets(config_); !ok) return ok;
  const Result<CameraPresets> all = [&] {
    std::lock_guard lock(presets_);
    return load_presets(config_.presets);
  }();
  if (!all) return forward(all);
  const auto preset = all->find(name);
  if (preset == all->end()) return fail(ErrorCode::NotFound, text("there is no preset '", name, "'"));
  Result<void> first;
  for (const auto& [serial, wanted] : preset->second)
    if (Result<void> set = set_all(*this, serial, wanted); !set && first) first = set;
  return first;
}

}  // namespace floatstage::studio
