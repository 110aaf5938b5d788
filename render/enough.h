#pragma once

namespace floatstage::render {

/// Of the weight that the chosen cameras would have if all of them saw a point, the share that keeps others
/// out: what is missing to it goes to the stand-ins (ADR 313).
inline constexpr float kEnough = 0.3F;

}  // namespace floatstage::render
