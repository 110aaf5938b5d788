#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/flow_trust.h"
#include "render/image_fill.h"

namespace floatstage::render {

/// Flow fields between all ordered pairs of images, made dependable: what an estimator says is kept where
/// it is believed (FlowTrust) and replaced by the smooth continuation of what is known around it elsewhere;
/// displacements within the estimator's own jitter become zero. Deterministic at any thread count. Keeps its
/// memory.
class PairwiseFlows {
 public:
  /// fields()[i * (n - 1) + (j < i ? j : j - 1)] is I_i -> I_j. Pairs whose j is not `wanted` stay zero.
  Result<void> estimate(const ProjectedImages& images, const std::vector<bool>& wanted,
                        const FlowOptions& options, int threads);

  const std::vector<FlowField>& fields() const { return fields_; }

 private:
  /// What one thread works with.
  struct Worker {
    FlowTrust trust;
    PictureFill fill;
  };
  void make_dependable(const ProjectedImages& images, std::size_t index, Worker& worker);

  std::optional<FlowOptions> options_;
  std::unique_ptr<FlowEstimator> estimator_;
  std::vector<FlowImage> pictures_;
  std::vector<FlowPair> asked_;
  std::vector<std::size_t> place_;  // of a pair among those that are asked for
  std::vector<FlowField> raw_, fields_;
  std::vector<Worker> workers_;
};

}  // namespace floatstage::render
