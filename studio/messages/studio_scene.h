#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/time.h"

namespace floatstage::studio {

/// What reconstruction hands to the viewers: the subject's surface at one instant, and whose pictures belong
/// to it. The pictures themselves go from the camera nodes to the viewers directly.
struct StudioScene {
  struct Camera {
    std::string serial;
    Timestamp exposed;  ///< finds its tile: that of the same exposure
    bool operator==(const Camera&) const = default;
  };
  std::uint64_t epoch = 0;  ///< number of the instant since reconstruction began
  Timestamp instant;
  Timestamp produced;           ///< of the view that was produced first: latency counts from here
  std::string rig_sha256;       ///< of the rig.json it was made with: a viewer with another one is told so
  std::vector<Camera> cameras;  ///< those that saw the instant
  std::string remark;  ///< what is wrong with it or with its silhouettes, for people; empty when nothing is
  Mesh mesh;
};

}  // namespace floatstage::studio
