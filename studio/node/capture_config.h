#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/recorder.h"
#include "core/result.h"
#include "studio/page/page_settings.h"

namespace floatstage::studio {

/// What a studio is: which cameras, how a recording is made and what it must keep to. A TOML file, for
/// people:
///
///   [studio]     frame_rate = 30, rig = "rig.json" (optional: without it a take is recorded uncalibrated),
///                times = "takes/rig/times.json" (optional), name = "stage left",
///                presets = "presets.toml" (optional: where the page's operators keep
///                settings of cameras; else beside the file, studio.presets.toml)
///   [recording]  folder = "takes", label = "rehearsal", codec = "ffv1" | "raw" | "h264", queue_frames = 64,
///                preroll_seconds = 2, keep_free_mb = 256, sync_seconds = 1, disagreement = "warn" | "refuse"
///   [limits]     skips = 0, duplicates = 0, spread_ms = 1.0, rate_deviation = 0.01
///   [web]        port = 8470, address = "127.0.0.1", token_file = "token", names = ["stage.local"]
///                (no table: no page)
///   [publish]    address = "tcp://127.0.0.1:5570", control = "tcp://127.0.0.1:5571", keys = "studio.keys",
///                key = "auto", plates = "plates", shrink = 2, tiles = "jpeg" | "raw", jpeg_quality = 90
///                (no table: nothing goes to the network)
///   [[camera]]   serial = "FAKE1", source = "gige:FAKE1?address=127.0.0.1"
///   [[sound]]    source = "alsa:default" (no table: takes have no sound)
///
/// Relative paths are relative to the file.
struct CaptureConfig {
  struct Camera {
    std::string serial;
    std::string source;  ///< a URI of open_source()
  };
  /// What the node tells the studio's other machines (studio/node/publishing_node.h). Needs a rig.
  struct Publish {
    std::string address = "tcp://127.0.0.1:5570";  ///< of outlines, tiles and status
    std::string control = "tcp://127.0.0.1:5571";  ///< of requests
    std::filesystem::path keys;                    ///< the studio's; needed off 127.0.0.1
    std::string key = "auto";                      ///< keyer spec, or each camera's own
    std::filesystem::path plates;                  ///< clean plates, <serial>.png
    int shrink = 2;                                ///< photograph pixels per keyed pixel, along each side
    bool raw_tiles = false;
    int jpeg_quality = 90;
  };
  std::string name = "studio";
  double frame_rate = 0;  ///< of every camera, frames a second
  std::filesystem::path rig;
  std::filesystem::path times;  ///< how far cameras' stamps are from their instants; empty: not known
  std::filesystem::path folder = "takes";
  capture::RecorderOptions recorder;  ///< its times: what load_times() found, once a node is open
  /// How much earlier than asked a take begins. Costs (preroll_seconds + 0.5) * frame_rate * 1.1 + 2 pictures
  /// of memory a camera: 8 cameras of 640x480 grey at 30 a second, 2 s: 208 MB.
  double preroll_seconds = 0;
  std::uint64_t keep_free_bytes = 256'000'000;  ///< a take is ended well before the disk is full
  bool refuse_disagreement = false;             ///< no take begins while the synchroniser complains
  std::optional<PageSettings> web;
  std::optional<Publish> publish;
  std::vector<Camera> cameras;
  std::vector<std::string> sounds = {};  ///< URIs of open_sound(), recorded beside the cameras
  std::filesystem::path presets = {};  ///< of the cameras' controls (camera_presets.h); empty: none are kept
};

/// Reads strictly: an unknown key is an error, so that a typing mistake never becomes a default. BadData
/// names the file, the line and what is understood. `base` is what relative paths are relative to.
Result<CaptureConfig> parse_capture_config(std::string_view toml, std::string_view name_for_errors,
                                           const std::filesystem::path& base);
Result<CaptureConfig> load_capture_config(const std::filesystem::path& file);

/// What CaptureConfig::times holds; no cameras when it names no file. Cameras of the studio that it says
/// nothing of are told. Errors: those of capture::load_time_offsets().
Result<capture::TimeOffsetFile> load_times(const CaptureConfig& config);

}  // namespace floatstage::studio
