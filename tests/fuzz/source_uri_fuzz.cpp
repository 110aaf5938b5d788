#include <cstdint>
#include <string_view>

#include "capture/source_uri.h"
#include "core/check.h"

// A camera as a studio's file names it, after its scheme: numbers within their bounds, or a sentence.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  struct Settings {
    std::optional<PixelFormat> format;
    int width = 0, height = 0, buffers = 8;
    double frame_rate = 0;
  } settings;
  const std::string address(reinterpret_cast<const char*>(data), size);
  capture::DeviceUri uri(address, "fuzz:" + address);
  uri.read_pictures(settings, 64);
  const std::uint64_t frames = uri.frames();
  const Result<void> fits = uri.options.finish("width=, height=");
  if (!fits) return 0;
  FLOATSTAGE_CHECK(frames > 0 && !uri.device.empty(), "a camera without a name");
  FLOATSTAGE_CHECK(settings.width >= 0 && settings.width <= 65535 && settings.buffers >= 2 &&
                       settings.buffers <= 64 && !(settings.frame_rate < 0),
                   "a number out of its bounds");
  return 0;
}
