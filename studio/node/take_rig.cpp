#include "studio/node/take_rig.h"

#include <algorithm>

#include "core/log.h"
#include "core/rig_io.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"

namespace floatstage::studio {

// Where nobody has calibrated yet, the cameras are put on a ring: a take must say where they stood.
Result<Rig> rig_of_take(const std::filesystem::path& file, const std::vector<LaneFacts>& lanes) {
  Rig known;
  if (!file.empty()) {
    Result<Rig> loaded = load_rig(file);
    if (!loaded) return loaded;
    known = std::move(*loaded);
  } else {
    log::warning(
        "no rig is given: the take is recorded with made-up camera positions; before processing it, "
        "calibrate "
        "and say `floatstage take set-rig TAKE rig.json -o NEW`");
  }
  SyntheticRigOptions ring;
  ring.cameras = static_cast<int>(lanes.size());
  Rig rig = synthetic_rig(ring);
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    RigCamera& camera = rig.cameras[i];
    const std::string& serial = lanes[i].serial;
    const ImageLayout& layout = lanes[i].layout;
    const auto calibrated = std::find_if(known.cameras.begin(), known.cameras.end(),
                                         [&](const RigCamera& c) { return c.serial == serial; });
    if (calibrated != known.cameras.end()) {
      camera = *calibrated;
    } else if (!file.empty()) {
      return fail(ErrorCode::NotFound, text(file.string(), ": camera '", serial,
                                            "' is not in it; calibrate again or correct the serial"));
    } else {
      camera.serial = serial;
      camera.model = CameraModel{layout.width,
                                 layout.height,
                                 1.0 * layout.width,
                                 1.0 * layout.width,
                                 0.5 * layout.width,
                                 0.5 * layout.height,
                                 0,
                                 {}};
    }
    if (camera.model.width != layout.width || camera.model.height != layout.height)
      return fail(
          ErrorCode::InvalidArgument,
          text("camera '", serial, "': it streams ", layout.width, "x", layout.height,
               " and was calibrated at ", camera.model.width, "x", camera.model.height, "; set that size"));
  }
  return rig;
}

}  // namespace floatstage::studio
