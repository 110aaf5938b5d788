// Method:  labels of least energy: expansion moves, each a minimum cut
// Paper:   Y. Boykov, O. Veksler, R. Zabih, "Fast Approximate Energy Minimization via Graph Cuts", PAMI 2001
// Differs: nothing
// ADR:     0274, 0298

#include "core/label_energy.h"

#include <algorithm>

#include "core/check.h"
#include "core/graph_cut.h"

namespace floatstage {
namespace {

constexpr int kRounds = 3;  // of expansions of all labels; the second hardly changes anything
constexpr std::int64_t kMost = 1'000'000'000;

// One move: every node keeps its label or takes `alpha`, whichever is cheapest for all together. Whether
// anything changed.
bool expand(int alpha, const LabelEnergy& e, GraphCut& graph, std::vector<std::uint8_t>& labels) {
  const int nodes = static_cast<int>(labels.size());
  graph.reset(nodes);
  std::vector<std::int64_t> keep(labels.size()), take(labels.size());
  for (std::size_t n = 0; n < labels.size(); ++n) {
    const std::int64_t* costs = e.costs.data() + n * static_cast<std::size_t>(e.count);
    keep[n] = costs[labels[n]];
    take[n] = costs[alpha];
  }
  for (const LabelEnergy::Pair& pair : e.pairs) {
    const auto p = static_cast<std::size_t>(pair.a), q = static_cast<std::size_t>(pair.b);
    // What the pair costs when (p, q) keep or take: 00, 01, 10; both taking costs nothing.
    const int c00 = labels[p] != labels[q] ? pair.weight : 0, c01 = labels[p] != alpha ? pair.weight : 0,
              c10 = labels[q] != alpha ? pair.weight : 0;
    // c00 + (c10 - c00) p + (0 - c10) q + (c01 + c10 - c00) (1 - p) q, of which the last is an edge.
    take[p] += c10 - c00;
    take[q] -= c10;
    if (const int edge = c01 + c10 - c00; edge > 0) graph.add_edge(pair.b, pair.a, edge, 0);
  }
  // The source's side takes: cut off the source a node pays for keeping.
  for (int n = 0; n < nodes; ++n) {
    const std::int64_t k = keep[static_cast<std::size_t>(n)], t = take[static_cast<std::size_t>(n)],
                       least = std::min(k, t);
    graph.add_terminals(n, static_cast<std::int32_t>(std::min(k - least, kMost)),
                        static_cast<std::int32_t>(std::min(t - least, kMost)));
  }
  graph.solve();
  bool changed = false;
  for (int n = 0; n < nodes; ++n)
    if (std::uint8_t& label = labels[static_cast<std::size_t>(n)];
        label != alpha && graph.on_source_side(n)) {
      label = static_cast<std::uint8_t>(alpha);
      changed = true;
    }
  return changed;
}

}  // namespace

void minimize(const LabelEnergy& energy, std::vector<std::uint8_t>& labels) {
  FLOATSTAGE_CHECK(
      energy.count > 0 && energy.costs.size() == labels.size() * static_cast<std::size_t>(energy.count),
      "a cost for each label of each node");
  if (labels.empty()) return;
  GraphCut graph(static_cast<int>(labels.size()), energy.pairs.size());
  for (int round = 0; round < kRounds; ++round) {
    bool changed = false;
    for (int alpha = 0; alpha < energy.count; ++alpha) changed |= expand(alpha, energy, graph, labels);
    if (!changed) break;
  }
}

}  // namespace floatstage
