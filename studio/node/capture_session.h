#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "capture/recorder.h"
#include "core/result.h"
#include "studio/node/capture_config.h"

namespace floatstage::studio {

class CaptureNode;

struct CaptureOptions {
  double seconds = 0;  ///< of streaming; 0: until stopped or until every source is over
  bool record = false;
  std::filesystem::path take;  ///< the new take's folder; empty: named by the time, in the config's folder
  /// Called before the cameras begin: somebody who looks at their pictures. What it returns lives until they
  /// have ended, and ends before the node does.
  std::function<Result<std::shared_ptr<void>>(CaptureNode&)> companion = {};
};

/// One camera of a session.
struct CapturedCamera {
  std::string serial;
  capture::SourceStats stats;  ///< summed over its connections
  std::uint64_t reconnects = 0;
  double frame_rate = 0;  ///< measured
  std::string trouble;    ///< the last error; empty while it streams
};

struct CaptureReport {
  std::vector<CapturedCamera> cameras;                 ///< in the config's order
  std::optional<capture::RecordingQuality> recording;  ///< when one was made
  std::filesystem::path take;
};

/// Runs all cameras, each on a thread of its own, and records what they deliver. A camera that is unplugged
/// is started again until the session ends; meanwhile the others go on, and its lost frames are rows that say
/// so. `stop` is asked a few times a second, while cameras start from several threads; a session that is
/// stopped then has no cameras in its report, and is Cancelled where it was to record. `progress` is told
/// about once a second. Errors: a source's URI, a camera that does not start at the beginning, the rig, and
/// the recording's disk. Fewer than all cameras is not a session: fix or remove it.
Result<CaptureReport> run_capture(const CaptureConfig& config, const CaptureOptions& options,
                                  const std::function<bool()>& stop,
                                  const std::function<void(const CaptureReport&)>& progress);

}  // namespace floatstage::studio
