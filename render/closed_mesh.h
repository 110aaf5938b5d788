#pragma once

#include "core/mesh.h"

namespace floatstage::render {

/// Every edge is as often run in one direction as in the other (so nothing is seen through holes) and the
/// volume is positive (so the first surface that a ray meets faces it).
bool is_closed(const Mesh& mesh);

}  // namespace floatstage::render
