#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/rig.h"
#include "studio/node/capture_config.h"

// Whatever parses as a studio's file is one that a node can begin with: named cameras, numbers within their
// bounds.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<studio::CaptureConfig> config =
      studio::parse_capture_config({reinterpret_cast<const char*>(data), size}, "fuzz", "/base");
  if (!config) return 0;
  FLOATSTAGE_CHECK(!config->cameras.empty(), "a studio without cameras");
  for (const studio::CaptureConfig::Camera& c : config->cameras) {
    FLOATSTAGE_CHECK(is_usable_serial(c.serial), "an unusable serial");
    FLOATSTAGE_CHECK(!c.source.empty(), "a camera without a source");
  }
  for (const std::string& sound : config->sounds) FLOATSTAGE_CHECK(!sound.empty(), "sound from nowhere");
  FLOATSTAGE_CHECK(std::isfinite(config->frame_rate) && config->frame_rate > 0, "a rate that is none");
  FLOATSTAGE_CHECK(std::isfinite(config->preroll_seconds) && config->preroll_seconds >= 0,
                   "a pre-roll that is none");
  if (config->publish)
    FLOATSTAGE_CHECK(config->publish->shrink >= 1 && config->publish->jpeg_quality >= 1,
                     "outlines of nothing");
  return 0;
}
