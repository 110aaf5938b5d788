#pragma once

#include <cstdint>
#include <vector>

namespace floatstage {

/// What is asked when nodes of a graph are given labels 0 … count - 1, in whole steps, so that the answer is
/// exact and repeatable; round weights of your own to, say, 1/1000.
struct LabelEnergy {
  struct Pair {
    int a = 0, b = 0;         ///< two different nodes
    std::int32_t weight = 0;  ///< >= 0: what it costs that their labels differ
  };
  int count = 2;
  std::vector<std::int64_t> costs;  ///< of each node in order, `count` numbers: what a label costs it
  std::vector<Pair> pairs;
};

/// Labels of a small sum of costs and of the weights of pairs that differ, from those that `labels` has at
/// first: one minimum cut for two labels, which is exact; expansion moves for more, each exact (Y. Boykov,
/// O. Veksler, R. Zabih, "Fast Approximate Energy Minimization via Graph Cuts", PAMI 2001). Deterministic.
void minimize(const LabelEnergy& energy, std::vector<std::uint8_t>& labels);

}  // namespace floatstage
