#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "render/flow.h"
#include "render/flow_trust.h"
#include "render/image_fill.h"

namespace floatstage::render {

/// The ordered pairs of n images in the order in which their fields stand: I_i -> I_j is number
/// i * (n - 1) + (j < i ? j : j - 1).
FlowPair flow_pair_at(std::size_t index, std::size_t images);
std::size_t flow_index_of(FlowPair pair, std::size_t images);

/// Flow fields between all ordered pairs of images, made dependable: what an estimator says is kept where
/// it is believed (FlowTrust) and replaced by the smooth continuation of what is known around it elsewhere;
/// displacements within the estimator's own jitter become zero. Deterministic at any thread count. Keeps its
/// memory.
class PairwiseFlows {
 public:
  /// fields() are those of flow_pair_at(). Pairs whose j is not `wanted` stay zero. Cancelled when it was
  /// interrupted: fields() are nobody's then.
  Result<void> estimate(const ProjectedImages& images, const std::vector<bool>& wanted,
                        const FlowOptions& options, int threads, Interruption* interruption = nullptr);

  std::span<const FlowField> fields() const { return {fields_.data(), pairs_}; }
  std::span<FlowField> fields() { return {fields_.data(), pairs_}; }  ///< may be changed

  /// Whether the next estimates keep what they believed.
  void keep_confidence(bool keep) { keeps_confidence_ = keep; }
  /// As fields(): a byte a pixel, how far what an estimator said was believed there, 0…255; empty for pairs
  /// that were not estimated.
  const std::vector<std::vector<std::uint8_t>>& confidence() const { return confidence_; }

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
  std::size_t pairs_ = 0;           // of the last estimate; of others, the memory is kept
  std::vector<FlowField> raw_, fields_;
  std::vector<std::vector<std::uint8_t>> confidence_;
  bool keeps_confidence_ = false;
  std::vector<Worker> workers_;
};

}  // namespace floatstage::render
