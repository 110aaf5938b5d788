#include "capture/camera_control.h"

#include <cmath>
#include <cstdint>

#include "core/text.h"

namespace floatstage::capture {
namespace {

// An exposure of ten seconds is 10000000 and not 1e+07.
std::string plain(double value) {
  const bool whole = std::abs(value) < 1e15 && value == std::floor(value);
  return whole ? std::to_string(static_cast<std::int64_t>(value)) : text(value);
}

}  // namespace

Result<void> check_control(const std::vector<CameraControl>& offered, const std::string& who,
                           const std::string& name, double value) {
  std::string names;
  for (const CameraControl& control : offered) {
    names += text(names.empty() ? "" : ", ", control.name);
    if (control.name != name) continue;
    if (value >= control.least && value <= control.most) return {};  // NaN is not
    return fail(ErrorCode::InvalidArgument,
                text(who, ": ", name, " = ", plain(value), " is out of range; it takes ",
                     plain(control.least), " to ", plain(control.most)));
  }
  return fail(ErrorCode::NotFound, text(who, ": it has no control '", name, "' that can be set now; it has ",
                                        names.empty() ? "none" : names));
}

}  // namespace floatstage::capture
