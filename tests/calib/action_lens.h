#pragma once

#include "core/camera.h"

namespace floatstage::calib {

/// An action camera's, nearly equidistant, for 120° from corner to corner: atan(r) as a quotient of
/// polynomials (Padé), and a little more. A strongly rational lens.
inline constexpr BrownConrady kActionLens{.k1 = 0.7778,
                                          .k2 = 0.0677,
                                          .p1 = 2e-4,
                                          .p2 = -3e-4,
                                          .k3 = 0.001,
                                          .k4 = 1.1111,
                                          .k5 = 0.2381,
                                          .k6 = 0.002};

}  // namespace floatstage::calib
