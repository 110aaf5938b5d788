#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "studio/node/camera_presets.h"

// Whatever parses as presets has names that the page can ask for and values that can be offered to a camera.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<studio::CameraPresets> presets =
      studio::parse_presets({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!presets) return 0;
  for (const auto& [name, preset] : *presets) {
    FLOATSTAGE_CHECK(studio::is_preset_name(name), "a name that nobody can ask for");
    for (const auto& [serial, controls] : preset)
      for (const auto& [control, value] : controls)
        FLOATSTAGE_CHECK(std::isfinite(value), "a value that is no number");
  }
  return 0;
}
