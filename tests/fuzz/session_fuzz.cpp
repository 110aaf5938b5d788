#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "core/rig.h"
#include "pipeline/calibrate/session.h"
#include "pipeline/calibrate/session_patterns.h"

// Whatever parses names its cameras so that files can be named after them, and says what to look at.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  const Result<pipeline::Session> session =
      pipeline::parse_session({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!session) return 0;
  FLOATSTAGE_CHECK(!session->observations.empty() ||
                       ((session->target || session->markerless) && !session->cameras.empty()),
                   "a session of nothing");
  for (const pipeline::SessionCamera& c : session->cameras) {
    FLOATSTAGE_CHECK(is_usable_serial(c.serial) || (c.serial.empty() && pipeline::is_camera_pattern(c)),
                     "an unusable serial");
    FLOATSTAGE_CHECK(!c.video.empty() || !c.images.empty() || !c.alone.empty() || !c.scene.empty(),
                     "a camera without pictures");
    FLOATSTAGE_CHECK(c.scene.empty() || session->markerless, "a scene that nobody looks at");
  }
  FLOATSTAGE_CHECK(session->every >= 1 && session->first_frame >= 0, "frames out of range");
  return 0;
}
