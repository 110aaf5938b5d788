#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage::render {

/// A picture for flow estimation: one grey plane, 0…255, rows top first.
struct FlowImage {
  int width = 0, height = 0;
  const std::uint8_t* gray = nullptr;  ///< width*height, tightly packed; not owned
};

/// Displacements in px: first(x, y) looks like second(x + u, y + v). Interleaved u, v.
struct FlowField {
  int width = 0, height = 0;
  std::vector<float> uv;  ///< 2 * width * height
};

struct FlowOptions {
  std::string backend = "dis";    ///< see flow_backends(); "none": nothing moves (no estimator)
  std::string preset = "medium";  ///< dis: "ultrafast", "fast", "medium"
  int finest_scale = 0;           ///< dis: level at which the search stops; 0 is full resolution
  int iterations = 0;             ///< 0: the preset's own
  int refinement = 20;            ///< dis: iterations of its variational refinement (not for "ultrafast")
  int shrink = 1;  ///< the pictures are reduced by this factor first, 1 … 8: much faster, softer
  bool operator==(const FlowOptions&) const = default;
};

/// Estimates optical flow on the CPU. Deterministic; each instance belongs to one thread at a time.
class FlowEstimator {
 public:
  virtual ~FlowEstimator() = default;
  virtual Result<FlowField> estimate(const FlowImage& first, const FlowImage& second) = 0;
};

Result<std::unique_ptr<FlowEstimator>> make_flow_estimator(const FlowOptions& options);
std::vector<std::string> flow_backends();

}  // namespace floatstage::render
