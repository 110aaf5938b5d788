#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "render/flow.h"

namespace floatstage {

/// The intermediate images I_i^v on the CPU, as the flow needs them.
struct ProjectedImages {
  enum State : std::uint8_t { kNoProxy = 0, kFilled = 128, kOwn = 255 };
  int width = 0, height = 0;
  std::vector<std::vector<std::uint8_t>> gray;   ///< per image, width * height
  std::vector<std::vector<std::uint8_t>> state;  ///< per image and pixel: where the colour comes from
};

/// Flow fields between all ordered pairs of images, made dependable: what an estimator says where an image has no
/// colour of its own, or where the way there and back does not meet, is replaced by the continuation of what is
/// known around it. Deterministic at any thread count: each pair has its own estimator.
class PairwiseFlows {
 public:
  /// fields()[i * (n - 1) + (j < i ? j : j - 1)] is I_i -> I_j. Pairs whose j is not `wanted` stay zero. Pictures are
  /// continued beyond the proxy first, so that its outline is no edge.
  Result<void> estimate(ProjectedImages images, const std::vector<bool>& wanted, const FlowOptions& options, int threads);

  const std::vector<FlowField>& fields() const { return fields_; }

 private:
  std::optional<FlowOptions> options_;
  std::vector<std::unique_ptr<FlowEstimator>> estimators_;
  std::vector<FlowField> fields_;
};

}  // namespace floatstage
