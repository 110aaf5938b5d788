#pragma once

#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::capture {

/// A knob of a camera that may be turned while it streams. Booleans are 0 and 1, menus their numbers.
struct CameraControl {
  std::string name;  ///< "exposure-us", "gain", "white-balance-red"; of V4L2 the driver's name in words
  double value = 0, least = 0, most = 0;
  double step = 0;  ///< 0: any value
};

/// Whether one of `offered` takes the value. NotFound lists what is offered, InvalidArgument has the range;
/// both begin with `who`.
Result<void> check_control(const std::vector<CameraControl>& offered, const std::string& who,
                           const std::string& name, double value);

}  // namespace floatstage::capture
