#include "capture/camera_control.h"

#include "core/text.h"

namespace floatstage::capture {

Result<void> check_control(const std::vector<CameraControl>& offered, const std::string& who,
                           const std::string& name, double value) {
  std::string names;
  for (const CameraControl& control : offered) {
    names += text(names.empty() ? "" : ", ", control.name);
    if (control.name != name) continue;
    if (value >= control.least && value <= control.most) return {};  // NaN is not
    return fail(ErrorCode::InvalidArgument, text(who, ": ", name, " = ", value, " is out of range; it takes ",
                                                 control.least, " to ", control.most));
  }
  return fail(ErrorCode::NotFound, text(who, ": it has no control '", name, "' that can be set now; it has ",
                                        names.empty() ? "none" : names));
}

}  // namespace floatstage::capture
