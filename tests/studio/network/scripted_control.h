#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "core/text.h"
#include "studio/messages/studio_control.h"

namespace floatstage::studio {

/// A camera node without cameras: it records takes that are nothing but names.
class ScriptedControl final : public StudioControl {
 public:
  NodeStatus status() const override {
    NodeStatus status;
    status.node = "left";
    NodeCamera warm;
    warm.serial = "cam0";
    warm.delivered = 300;
    warm.lost = 18'000'000'000'000'000'000u;
    warm.frame_rate = 29.97;
    warm.starved = 2;
    warm.width = 640;
    warm.height = 480;
    warm.temperature_c = 41.5;
    warm.bandwidth_mbit = 73.7;
    NodeCamera gone;
    gone.serial = "cam1";
    gone.trouble = "camera 'cam1': \"unplugged\"";
    status.cameras = {warm, gone};
    status.spread_p50_ms = 0.125;
    status.spread_max_ms = 0.5;
    status.disk_free_bytes = 1'000'000'000'000;
    status.frame_rate = 30;
    status.complaints = {"camera 'cam1' is silent"};
    status.disk_minutes = 75.5;
    status.preroll_seconds = 1;
    std::lock_guard lock(mutex_);
    if (!recorded_.empty()) {
      status.recording.emplace();
      status.recording->take = recorded_;
      status.recording->seconds = 2.5;
      status.recording->frames = 600;
      status.recording->complaints = {"camera 'cam1': 1 skip"};
      status.recording->sounds = {{"sound", 2.5, 0.25, false}, {"sound2", 1.5, 0, true}};
    }
    return status;
  }
  Result<std::string> start_recording(const std::string& label) override {
    std::lock_guard lock(mutex_);
    if (!recorded_.empty())
      return fail(ErrorCode::AlreadyExists, text("'", recorded_, "' is being recorded; stop it first"));
    return recorded_ = "take-" + label;
  }
  Result<void> stop_recording() override {
    std::lock_guard lock(mutex_);
    if (recorded_.empty()) return fail(ErrorCode::NotFound, "nothing is being recorded");
    recorded_.clear();
    return {};
  }
  Result<std::vector<NodeTake>> takes() const override {
    return std::vector<NodeTake>{{"take-b", "2026-01-02T03:04:05Z", 123'456'789'012, true, "PASS", 61.5, 8},
                                 {"take-a", "2026-01-01T03:04:05Z", 1, false, "", 0, 8}};
  }

 private:
  mutable std::mutex mutex_;
  std::string recorded_;
};

}  // namespace floatstage::studio
