#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/text.h"
#include "studio/node/capture_config.h"

namespace floatstage::studio {

/// A studio of live synthetic cameras, triggered together, that records raw pictures into `folder`. `more`
/// are further options of camera 0's URI.
inline CaptureConfig live_studio(int cameras, double rate, const std::filesystem::path& folder,
                                 const std::string& more = "") {
  CaptureConfig config;
  config.name = "test studio";
  config.frame_rate = rate;
  config.folder = folder;
  config.keep_free_bytes = 0;
  config.recorder.take.frame_rate = rate;
  config.recorder.take.codec = capture::TakeCodec::Raw;
  config.recorder.take.label = "take";
  for (int i = 0; i < cameras; ++i)
    config.cameras.push_back(
        {text("CAM", i + 1), text("synthetic:live=on&loop=2&width=64&height=48&samples=1&cameras=", cameras,
                                  "&camera=", i, "&rate=", rate, i == 0 ? more : "")});
  return config;
}

}  // namespace floatstage::studio
