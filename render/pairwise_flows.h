#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/flow_trust.h"

namespace floatstage::render {

/// Flow fields between all ordered pairs of images, made dependable: what an estimator says is kept where
/// it is trusted() and replaced by the smooth continuation of what is known around it elsewhere;
/// displacements within the estimator's own jitter become zero. Deterministic at any thread count.
class PairwiseFlows {
 public:
  /// fields()[i * (n - 1) + (j < i ? j : j - 1)] is I_i -> I_j. Pairs whose j is not `wanted` stay zero.
  Result<void> estimate(const ProjectedImages& images, const std::vector<bool>& wanted,
                        const FlowOptions& options, int threads);

  const std::vector<FlowField>& fields() const { return fields_; }

 private:
  std::optional<FlowOptions> options_;
  std::unique_ptr<FlowEstimator> estimator_;
  std::vector<FlowField> raw_, fields_;
};

}  // namespace floatstage::render
