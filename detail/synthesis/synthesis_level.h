#pragma once

#include "detail/synthesis/synthesis.h"

namespace floatstage::detail {

/// One level of a synthesis, made of the next coarser one.
class SynthesisLevel {
 public:
  SynthesisLevel(const Synthesis& synthesis, int level) : s_(synthesis), level_(level) {}

  /// The part of the coarser level that `wanted` depends on.
  Region needed(const Region& wanted) const;
  /// `coarse`: that part.
  SynthesisTile make(const Region& wanted, const SynthesisTile& coarse) const;

 private:
  struct Work;
  using Place = Exemplars::Place;

  Region worked_on(const Region& wanted, int iterations) const;
  void find_matches(Work& work, const SynthesisTile& coarse) const;
  void place_layers(Work& work) const;
  void color(Work& work, const Region& region) const;
  void improve(Work& work, const Region& region, bool first) const;
  Place best_candidate(const Work& work, int x, int y, bool first) const;

  const Synthesis& s_;
  int level_;
};

}  // namespace floatstage::detail
