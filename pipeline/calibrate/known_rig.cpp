#include <algorithm>
#include <cmath>
#include <iomanip>

#include "calib/rig_formats.h"
#include "core/text.h"
#include "pipeline/calibrate/session_observations.h"

namespace floatstage::pipeline {

Result<Rig> load_known(const SessionKnown& known) {
  Result<calib::ForeignRig> read = calib::read_rig({known.format, known.file, known.metres_per_unit});
  if (!read) return forward(read);
  return std::move(read->rig);
}

Result<void> apply_known(const SessionKnown& known, const Rig& rig, calib::Observations& o) {
  for (calib::CalibrationCamera& c : o.cameras) {
    const int index = camera_index(rig, c.serial);
    if (index < 0)
      return fail(ErrorCode::NotFound, text(known.file.string(), ": there is no camera '", c.serial,
                                            "' in it; name the session's cameras as they are named there"));
    const RigCamera& from = rig.cameras[static_cast<std::size_t>(index)];
    if (known.intrinsics != calib::Prior::Unknown) {
      c.intrinsics = known.intrinsics;
      c.model = from.model;
      if (c.model.width == 0) {  // a format that does not state it
        c.model.width = c.width;
        c.model.height = c.height;
      }
      if (c.model.lens.index() != 0) c.lens = static_cast<calib::LensKind>(c.model.lens.index());
    }
    if (known.poses != calib::Prior::Unknown) {
      c.pose = known.poses;
      c.cam_from_world = from.cam_from_world;
    }
  }
  return {};
}

std::optional<Result<calib::RigAgreement>> compare_poses(const SessionKnown& known, const Rig& rig,
                                                         const Rig& solved) {
  if (known.poses != calib::Prior::Unknown) return std::nullopt;
  return calib::agreement(solved, rig);
}

std::vector<std::string> compare_to_known(const SessionKnown& known, const Rig& rig, const Rig& solved) {
  std::vector<std::string> out;
  if (known.intrinsics != calib::Prior::Unknown) return out;
  for (const RigCamera& c : solved.cameras) {
    const int index = camera_index(rig, c.serial);
    if (index < 0) continue;
    const CameraModel& was = rig.cameras[static_cast<std::size_t>(index)].model;
    out.push_back(text("camera '", c.serial, "': focal length ", std::fixed, std::setprecision(1), c.model.fx,
                       " px, ", std::setprecision(2), 100 * (c.model.fx / was.fx - 1), " % from the known ",
                       std::setprecision(1), was.fx, " px; principal point ",
                       std::hypot(c.model.cx - was.cx, c.model.cy - was.cy), " px from the known one"));
  }
  return out;
}

}  // namespace floatstage::pipeline
