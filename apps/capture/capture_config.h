#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "capture/recorder.h"
#include "core/result.h"

namespace floatstage {

/// What a studio is: which cameras, how a recording is made and what it must keep to. A TOML file, for
/// people:
///
///   [studio]     frame_rate = 30, rig = "rig.json" (optional: without it a take is recorded uncalibrated)
///   [recording]  folder = "takes", label = "rehearsal", codec = "ffv1" | "raw" | "h264", queue_frames = 64
///   [limits]     skips = 0, duplicates = 0, spread_ms = 1.0, rate_deviation = 0.01
///   [[camera]]   serial = "FAKE1", source = "gige:FAKE1?address=127.0.0.1"
///
/// Relative paths are relative to the file.
struct CaptureConfig {
  struct Camera {
    std::string serial;
    std::string source;  ///< a URI of open_source()
  };
  double frame_rate = 0;  ///< of every camera, frames a second
  std::filesystem::path rig;
  std::filesystem::path folder = "takes";
  RecorderOptions recorder;
  std::vector<Camera> cameras;
};

/// Reads strictly: an unknown key is an error, so that a typing mistake never becomes a default. BadData
/// names the file, the line and what is understood. `base` is what relative paths are relative to.
Result<CaptureConfig> parse_capture_config(std::string_view toml, std::string_view name_for_errors,
                                           const std::filesystem::path& base);
Result<CaptureConfig> load_capture_config(const std::filesystem::path& file);

}  // namespace floatstage
