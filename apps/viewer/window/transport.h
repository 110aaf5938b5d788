#pragma once

#include "apps/viewer/window/time_line.h"

namespace floatstage::apps {

/// The buttons that play and step; what follows stands beside them. Draws into the present ImGui window.
void draw_transport(TimeLine& time);

}  // namespace floatstage::apps
