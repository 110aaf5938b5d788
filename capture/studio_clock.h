#pragma once

#include "core/time.h"

namespace floatstage::capture {

/// Now, on the recorder's monotonic clock: the studio clock wherever PTP does not give a better one. Safe
/// from any thread. Only sources read it; everything after them gets time as a parameter.
Timestamp studio_now();

}  // namespace floatstage::capture
