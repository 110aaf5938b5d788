#pragma once

#include <cstdint>

namespace floatstage::render {

/// Of a view: pixels that show the proxy, and how many of these some camera of its list sees. A shader writes
/// it.
struct SeenPixels {
  std::uint32_t shown = 0, seen = 0;
};

}  // namespace floatstage::render
